#pragma once

#include <map>
#include <utility>
#include <vector>

#include "core/pipeline/lidar_result.h"
#include "core/quality/verdict.h"

namespace rigcal {

/// Points, and those of them on planes that were made of points.
struct UsedPoints {
  double seen = 0.0;
  double used = 0.0;

  UsedPoints& operator+=(const UsedPoints& other) {
    seen += other.seen;
    used += other.used;
    return *this;
  }
  [[nodiscard]] double share() const { return seen > 0.0 ? used / seen : 0.0; }
};

/// By LiDAR and stop, of the patches with `use`.
[[nodiscard]] std::map<std::pair<int, int>, UsedPoints> used_points(const std::vector<PatchCells>& patches,
                                                                    const std::vector<char>& use, const PlaneMap& map);

/// How much of what a LiDAR saw lies on planes, 0 .. 1. Little: it hangs on false matches.
struct UsedShare {
  double all = 0.0;
  HalfShares halves;  ///< Of its stops, told by their indices; both are `all` where it has fewer than four.
};

/// One for each LiDAR, of the patches that took part.
[[nodiscard]] std::vector<UsedShare> used_shares(const LidarRecording& recording, const LidarSolution& solution);

}  // namespace rigcal
