#pragma once

#include "core/base/random.h"
#include "core/geometry/se3.h"
#include "simdata/rig/turntable_motion.h"

namespace rigcal::sim {

/// Errors of an inertial unit of the AVIA's class, drawn once a run.
struct ImuErrors {
  Vector3d gyro_bias_rad_s = Vector3d::Zero();
  Vector3d gyro_scale = Vector3d::Zero();  ///< Reads (1 + scale) times the rate.
  double gyro_sigma_rad_s = 0.0;           ///< Of each reading, each axis.
  Vector3d accelerometer_bias_g = Vector3d::Zero();
  double accelerometer_sigma_g = 0.0;

  /// Bias 0.1 to 0.3 deg/s either way each axis, scale 5e-4, noise 0.05 deg/s; 5 mg and 2 mg.
  [[nodiscard]] static ImuErrors draw(Random& random);
};

/// The inertial unit of a sensor that rides on the turntable, its axes those of the sensor. It sits at the sensor's
/// origin: the real one is centimetres off, which at these rates is below 2 mg.
class ImuModel {
 public:
  ImuModel(const TurntableMotion& motion, const SE3& T_base_sensor, const ImuErrors& errors)
      : motion_(motion), T_base_sensor_(T_base_sensor), errors_(errors) {}

  /// True turn rate, rad/s, and true specific force in g (at rest 1 g upwards), both in the sensor's frame.
  [[nodiscard]] Vector3d turn_rate(double time_s) const;
  [[nodiscard]] Vector3d specific_force_g(double time_s) const;

  /// The same as the sensor reads it.
  [[nodiscard]] Vector3d read_gyro(double time_s, Random& random) const;
  [[nodiscard]] Vector3d read_accelerometer_g(double time_s, Random& random) const;

 private:
  [[nodiscard]] SE3 T_scene_sensor(double time_s) const { return motion_.T_scene_base(time_s) * T_base_sensor_; }

  const TurntableMotion& motion_;
  SE3 T_base_sensor_;
  ImuErrors errors_;
};

}  // namespace rigcal::sim
