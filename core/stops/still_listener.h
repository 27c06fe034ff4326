#pragma once

#include <cstdint>

#include "core/records/records.h"

namespace rigcal {

/// Why points are in no patch.
enum class DropReason { before_first_stop, moving, swing, short_stop, overflow, late, after_last_stop };
constexpr std::size_t drop_reasons = 7;
[[nodiscard]] const char* to_string(DropReason reason);

/// What ended a stop.
enum class StopEnd {
  motion,
  creep,    ///< The rig slowly drifted off the place where it had come to rest.
  silence,  ///< No data for too long, or the clock jumped.
  stream,   ///< The recording's end.
};
[[nodiscard]] const char* to_string(StopEnd end);

/// One stop as the inertial unit or the points saw it.
struct StillStop {
  Stop stop;
  int sensor = -1;  ///< In whose frame rotation, acceleration and bias are; -1: none, the rotation is not known.
  /// Rotation from the previous stop, in that sensor's frame: maps directions of this stop into the previous one.
  /// Identity for the first stop.
  Matrix3d R_previous_this = Matrix3d::Identity();
  double rotation_sigma_rad = 0.0;             ///< 1 sigma about any axis; 0 for the first stop.
  bool rotation_known = true;                  ///< False: nothing told of the way, the rotation means nothing.
  Vector3d acceleration_g = Vector3d::Zero();  ///< Mean; points up in the unit's frame. Zero without a unit.
  Vector3d gyro_bias_rad_s = Vector3d::Zero();
  bool imu_gap = false;  ///< A short silence of the unit inside the stop was bridged.
  StopEnd end = StopEnd::motion;
  double tremble_rad = 0.0;  ///< Points only: root mean square of a trembling inside the stop.
};

/// A rest that goes on, as far as it is judged: for who watches a recording while it is made.
struct RestNow {
  std::int64_t since_ns = 0;    ///< When the rig seems to have come to rest.
  std::int64_t settled_ns = 0;  ///< Where its stop starts, or will start should it last.
  std::int64_t until_ns = 0;    ///< Up to here it is known to rest.
  int stop = -1;                ///< The stop that goes on; -1: too short for one so far.
};

/// Told, in order of time and without holes, what the rig did. Whatever finds stops (from a gyro, from points, from a
/// table's angles) drives the patches through these calls.
class StillListener {
 public:
  virtual ~StillListener() = default;
  virtual void not_still_until(std::int64_t until_ns, DropReason reason) = 0;
  virtual void still_until(std::int64_t until_ns, int stop) = 0;
  virtual void stop_ended(const StillStop& stop) = 0;
};

}  // namespace rigcal
