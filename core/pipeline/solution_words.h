#pragma once

#include <string>
#include <vector>

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// How far a pass moved the LiDARs, for --log-level debug.
[[nodiscard]] std::string move_words(const std::vector<ExtrinsicMove>& moves);

/// Where a LiDAR stands, how its start was found, and its noise, for --log-level debug.
[[nodiscard]] std::string place_words(int lidar, const LidarSolution& solution);

}  // namespace rigcal
