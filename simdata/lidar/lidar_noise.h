#pragma once

#include "core/records/lidar_models.h"

namespace rigcal::sim {

/// How a LiDAR errs. One sigma unless said otherwise; ranges in metres.
struct LidarNoise {
  double range_sigma = 0.015;          ///< At the lens,
  double range_sigma_per_m = 0.25e-3;  ///< growing with range,
  double range_sigma_max = 0.04;       ///< up to this; at grazing incidence 1.3 times as much (the echo gets longer).
  double range_bias = 0.0;             ///< Of this unit: its ranges are so much too long,
  double dark_bias = 0.0;        ///< and on a black target by this more, less where more comes back (see `bias_at`).
  double angle_sigma_rad = 0.0;  ///< Of the reported direction, in each of two directions across the ray.
  double min_range = 1.0;        ///< Nearer surfaces give no return.
  double max_range = 450.0;
  double range_at_10_percent = 190.0;  ///< Where half of the shots at a 10 % target return (data sheet).
  double lost_share = 0.002;           ///< Shots lost for no visible reason.
  double divergence_y_rad = 0.0;       ///< Full width of the beam along the sensor's y,
  double divergence_z_rad = 0.0;       ///< and along its z: the beam is much higher than wide.
  double second_ray_share = 0.2;       ///< Shots of which a second part of the footprint is looked at.
  double pulse_length = 0.75;  ///< Two surfaces in one footprint nearer together than this (5 ns) come as one point.

  /// Of a model whose scan is known: 15 mm + 0.25 mm/m, all else as core/records/lidar_models.h has it.
  [[nodiscard]] static LidarNoise of(LidarModel model);
  /// No noise, no losses, no bleeding: for tests.
  [[nodiscard]] static LidarNoise none();

  [[nodiscard]] double range_sigma_at(double range, double cos_incidence) const;
  /// range_bias + dark_bias (1 - reflectivity / 100), the reflectivity at most 100 and as the sensor sees it (a surface
  /// that the beam meets aslant is darker): a weak echo crosses the threshold late.
  [[nodiscard]] double bias_at(double reflectivity) const;
};

}  // namespace rigcal::sim
