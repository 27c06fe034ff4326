#include "core/voxel/noise_model.h"

#include <algorithm>

namespace rigcal {

Matrix3d NoiseModel::point_covariance(const Vector3d& p_sensor) const {
  const double r2 = p_sensor.squaredNorm();
  const double along = range_m * range_m + range_per_m * range_per_m * r2;
  const double across = angle_rad * angle_rad * r2;
  return across * Matrix3d::Identity() + (along - across) / std::max(r2, 1e-12) * (p_sensor * p_sensor.transpose());
}

double NoiseModel::variance_along(const Vector3d& p_sensor, const Vector3d& u) const {
  const double r2 = p_sensor.squaredNorm();
  const double d = u.dot(p_sensor);
  const double cos2 = d * d / std::max(r2, 1e-12);
  const double along = range_m * range_m + range_per_m * range_per_m * r2;
  return along * cos2 + angle_rad * angle_rad * r2 * (1.0 - cos2);
}

}  // namespace rigcal
