#pragma once

#include <vector>

#include "core/quality/result.h"
#include "core/voxel/cells.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// The thinned points of all patches with `use`, in the world, one for each cube of `size_m` (0: all of them).
/// `sensor_of[lidar]` goes to MapPoint::sensor.
[[nodiscard]] std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                                             const std::vector<char>& use, const std::vector<int>& sensor_of,
                                             double size_m);

}  // namespace rigcal
