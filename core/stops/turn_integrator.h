#pragma once

#include "core/stops/motion_bins.h"

namespace rigcal {

/// The gyro's mean over one stop.
struct StillGyro {
  Vector3d bias_rad_s = Vector3d::Zero();
  double samples = 0.0;
  std::int64_t middle_ns = 0;
};

struct Turn {
  Matrix3d R_previous_this = Matrix3d::Identity();
  double sigma_rad = 0.0;  ///< 1 sigma about any axis.
  double longest_interval_s = 0.0;
};

/// Integrates the gyro from one stop to the next on SO(3). The bias at the far end is not known on the way, so the
/// derivative with respect to a bias that changes linearly in time is carried along (preintegration: Forster et al.,
/// On-Manifold Preintegration, TRO 2017, eq. 44): memory does not grow with the length of the turn.
class TurnIntegrator {
 public:
  /// Starts anew at the end of a stop.
  void begin(const StillGyro& from);
  void add(const MotionBin& bin);
  /// `noise_variance`: of a gyro sample, mean over the axes, (rad/s)^2. `scale_sigma`: see StopOptions.
  [[nodiscard]] Turn finish(const StillGyro& to, double noise_variance, double scale_sigma) const;

 private:
  StillGyro from_;
  Matrix3d R_ = Matrix3d::Identity();
  Matrix3d derivative_ = Matrix3d::Zero();  ///< Of the right tangent by the bias's slope in rad/s^2.
  double angle_ = 0.0;                      ///< Path length, rad.
  double length_s_ = 0.0;
  double interval2_sum_ = 0.0;  ///< Sum of squared sample intervals, s^2.
  double longest_interval_s_ = 0.0;
};

}  // namespace rigcal
