#pragma once

#include <vector>

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// How much of what a LiDAR saw lies on planes, 0 .. 1. Little: it hangs on false matches.
struct UsedShare {
  double all = 0.0;
  /// Of the earlier and of the later half of its stops; equal where it has fewer than four.
  double earlier = 0.0;
  double later = 0.0;
  int first_later_stop = 0;  ///< With which the later half begins; an index.
};

/// One for each LiDAR, of the patches that took part.
[[nodiscard]] std::vector<UsedShare> used_shares(const LidarRecording& recording, const LidarSolution& solution);

}  // namespace rigcal
