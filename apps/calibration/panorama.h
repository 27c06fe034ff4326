#pragma once

#include <cstdint>
#include <vector>

#include "core/pipeline/lidar_calibration.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// Which LiDARs have seen something in each direction of the world, all stops together.
struct Panorama {
  static constexpr int columns = 120;       ///< Of three degrees, from behind over the left, ahead and the right.
  static constexpr int rows = 30;           ///< From 45 degrees up to 45 degrees down.
  static constexpr int most_lidars = 32;    ///< As many as are recorded live.
  std::vector<std::uint32_t> seen_by = {};  ///< Row by row; a bit for each LiDAR.
};

/// From the stops and LiDARs that are known (one entry for each); the last stop of `state` may be behind `recording`.
[[nodiscard]] Panorama find_panorama(const LidarRecording& recording, const RigState& state,
                                     const std::vector<char>& stop_known, const std::vector<char>& lidar_known);

}  // namespace rigcal
