#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// Measurement noise of one LiDAR: across the ray r angle_rad, along it
/// sigma_r(r, i)^2 = (range_m^2 + (range_per_m r)^2) (1 + slant_growth (1 - cos i))^2 where it meets a surface at the
/// incidence i: a spot that is drawn out by a slant gives a longer echo. The variance of a point's distance to that
/// plane is sigma_r^2 cos^2 i + r^2 angle_rad^2 sin^2 i.
struct NoiseModel {
  double range_m = 0.02;  ///< The data sheets' 2 cm, until the data say better.
  double range_per_m = 0.0;
  double angle_rad = 0.0005;
  double slant_growth = 0.0;  ///< Of the range's sigma; 0: the same at any incidence.

  /// Of a range, m^2, for a point of squared range r2 (m^2) on a surface met at this incidence.
  [[nodiscard]] double range_variance(double r2, double cos_incidence) const;
  /// Covariance, m^2, of a single point at p on a surface with the unit normal n (sensor frame both).
  [[nodiscard]] Matrix3d point_covariance(const Vector3d& p_sensor, const Vector3d& n) const;
  /// Its variance along n, m^2: that of its distance to the surface.
  [[nodiscard]] double variance_along(const Vector3d& p_sensor, const Vector3d& n) const;
};

}  // namespace rigcal
