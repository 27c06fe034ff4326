#pragma once

#include <vector>

#include "core/quality/lidar_quality.h"

namespace rigcal {

/// How far the earlier and the later half of the stops in which a LiDAR lies on planes disagree about its place: a
/// mount that slipped during the recording.
struct TimeHalves {
  bool compared = false;     ///< Two stops and more of each half tell.
  int first_later_stop = 0;  ///< With which the later half begins.
  /// Of the difference over its covariance; 22.5 is exceeded by chance in one of a thousand.
  double chi2 = 0.0;
  /// The difference itself, drawn to zero in directions in which the halves do not tell.
  double rotation_rad = 0.0;
  double translation_m = 0.0;
};

/// Of each LiDAR, the base included, by one Gauss-Newton step from where everything was solved, against the planes of
/// all. That the planes followed what slipped changes nothing of the difference; where the stops did, the others show
/// the part that it lacks.
[[nodiscard]] std::vector<TimeHalves> compare_time_halves(const SolvedPlanes& solved);

}  // namespace rigcal
