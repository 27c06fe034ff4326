#pragma once

#include <cstddef>
#include <map>

#include "core/geometry/se3.h"

namespace rigcal {

/// What tells whether the rig stands still.
enum class StopSource {
  gyro,    ///< An inertial unit; the points are watched for creep.
  points,  ///< What the LiDARs see.
};

/// How stops are found. Thresholds against noise are made from the sensor's own noise while it runs; what stands here
/// is what matters to the map or what a gyro may be like, not what one rig is like.
struct StopOptions {
  StopSource source = StopSource::gyro;
  /// The sensor whose inertial unit decides; -1: the first one that is heard.
  int imu_sensor = -1;
  /// Scale and alignment error of the gyro, 1 sigma: enters the sigma of a rotation only. MEMS: 0.5 %.
  double gyro_scale_sigma = 0.005;
  /// The table's axis (unit) in the frames of sensors where it is roughly known: the points of such a LiDAR need to
  /// show turns about it only. Those of others must show turns about any axis.
  std::map<int, Vector3d> turn_axes = {};
  /// Points held until their time is decided, about 2 s of all sensors: 4 million hold 2 M points/s in 64 MB, and are
  /// enough for what is live.
  std::size_t max_held_points = 4'000'000;

  // What is the same for every rig.

  /// Shorter rests are dropped. Half a second gives a non-repetitive LiDAR about a quarter of its field of view.
  static constexpr double min_stop_s = 0.5;
  /// Amplitude of a swing that may be in a patch: 0.1 mrad is 2 mm at 20 m, a tenth of a LiDAR's range noise.
  static constexpr double angle_limit_rad = 1e-4;
  /// Slow turning that is taken for a change of bias: MEMS gyros move by a few 0.01 deg/s in a run that warms up.
  static constexpr double creep_limit_rad_s = to_rad(0.05);
  /// Largest bias (norm). MEMS gyros are specified to 1 deg/s on an axis. A faster steady rate is always a rotation.
  static constexpr double max_bias_rad_s = to_rad(2.0);
  /// Noise of a sample (1 sigma, an axis) above which no stop can be judged; usual are 0.05 to 0.2 deg/s.
  static constexpr double max_gyro_noise_rad_s = to_rad(0.5);
  /// Swings of the mean acceleration over 25 ms that are no rest: a rig that is pushed along without turning. Foot
  /// steps beside a rig stay below 0.001 g.
  static constexpr double bump_limit_g = 0.01;
  /// Cut off at both ends: covers what a LiDAR's mapped clock may be off, and the onset below the noise.
  static constexpr double margin_s = 0.05;
  /// Shorter silence of the inertial unit inside a stop is bridged: no turn with its swing fits in. At most 0.3.
  static constexpr double bridge_gap_s = 0.2;
  /// Longer silence while the rig turns makes the rotation unknown: at 100 deg/s^2 this leaves 0.05 deg.
  static constexpr double max_turn_gap_s = 0.06;
  /// A rotation less sure than that (1 sigma) is not known: a start must be nearer.
  static constexpr double most_rotation_sigma_rad = to_rad(10.0);
  /// Longest wait for a swing to fade, after nothing of it stands out of the noise.
  static constexpr double max_settle_s = 2.0;
  /// Of a file, where nobody is kept waiting: ten LiDARs of 128 beams, in 1 GB where they are that dense.
  static constexpr std::size_t held_points_of_files = 64'000'000;
};

}  // namespace rigcal
