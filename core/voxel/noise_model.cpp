#include "core/voxel/noise_model.h"

#include <algorithm>
#include <cmath>

namespace rigcal {

double NoiseModel::range_variance(double r2, double cos_incidence) const {
  const double growth = 1.0 + slant_growth * (1.0 - cos_incidence);
  return (range_m * range_m + range_per_m * range_per_m * r2) * growth * growth;
}

Matrix3d NoiseModel::point_covariance(const Vector3d& p_sensor, const Vector3d& n) const {
  const double r2 = p_sensor.squaredNorm();
  const double along = range_variance(r2, std::abs(n.dot(p_sensor)) / std::sqrt(std::max(r2, 1e-12)));
  const double across = angle_rad * angle_rad * r2;
  return across * Matrix3d::Identity() + (along - across) / std::max(r2, 1e-12) * (p_sensor * p_sensor.transpose());
}

double NoiseModel::variance_along(const Vector3d& p_sensor, const Vector3d& n) const {
  const double r2 = p_sensor.squaredNorm();
  const double d = n.dot(p_sensor);
  const double cos2 = d * d / std::max(r2, 1e-12);
  return range_variance(r2, std::sqrt(cos2)) * cos2 + angle_rad * angle_rad * r2 * (1.0 - cos2);
}

}  // namespace rigcal
