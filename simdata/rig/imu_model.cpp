#include "simdata/rig/imu_model.h"

#include "simdata/scene/random_vectors.h"

namespace rigcal::sim {
namespace {

// Step of the central differences, s. The motion changes within 50 ms: their error is below 1e-4 of the value.
constexpr double h = 1e-3;
constexpr double standard_gravity = 9.80665;

}  // namespace

ImuErrors ImuErrors::draw(Random& random) {
  ImuErrors errors;
  for (int axis = 0; axis < 3; ++axis) {
    const double sign = random.uniform() < 0.5 ? -1.0 : 1.0;
    errors.gyro_bias_rad_s[axis] = sign * to_rad(random.uniform(0.1, 0.3));
  }
  errors.gyro_scale = 5e-4 * random_normal3(random);
  errors.gyro_sigma_rad_s = to_rad(0.05);
  errors.accelerometer_bias_g = 5e-3 * random_normal3(random);
  errors.accelerometer_sigma_g = 2e-3;
  return errors;
}

Vector3d ImuModel::turn_rate(double time_s) const {
  const Matrix3d before = T_scene_sensor(time_s - h).R;
  const Matrix3d after = T_scene_sensor(time_s + h).R;
  return log_so3(before.transpose() * after) / (2.0 * h);
}

Vector3d ImuModel::specific_force_g(double time_s) const {
  const SE3 T = T_scene_sensor(time_s);
  const Vector3d acceleration = (T_scene_sensor(time_s - h).t - 2.0 * T.t + T_scene_sensor(time_s + h).t) / (h * h);
  return T.R.transpose() * (acceleration / standard_gravity + Vector3d::UnitZ());
}

Vector3d ImuModel::read_gyro(double time_s, Random& random) const {
  const Vector3d rate = turn_rate(time_s);
  return rate + errors_.gyro_scale.cwiseProduct(rate) + errors_.gyro_bias_rad_s +
         errors_.gyro_sigma_rad_s * random_normal3(random);
}

Vector3d ImuModel::read_accelerometer_g(double time_s, Random& random) const {
  return specific_force_g(time_s) + errors_.accelerometer_bias_g +
         errors_.accelerometer_sigma_g * random_normal3(random);
}

}  // namespace rigcal::sim
