#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// Measurement noise of one LiDAR: along the ray sigma_r(r)^2 = range_m^2 + (range_per_m r)^2, across it r angle_rad.
/// The variance of a point's distance to a plane met at incidence i is sigma_r^2 cos^2 i + r^2 angle^2 sin^2 i
/// (architecture 3.3).
struct NoiseModel {
  double range_m = 0.02;  ///< The data sheets' 2 cm, until the data say better.
  double range_per_m = 0.0;
  double angle_rad = 0.0005;

  /// Covariance of a single point at p (sensor frame).
  [[nodiscard]] Matrix3d point_covariance(const Vector3d& p_sensor) const;
  /// Its variance along the unit vector u (sensor frame).
  [[nodiscard]] double variance_along(const Vector3d& p_sensor, const Vector3d& u) const;
};

}  // namespace rigcal
