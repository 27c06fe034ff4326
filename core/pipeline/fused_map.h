#pragma once

#include <vector>

#include "core/quality/result.h"
#include "core/voxel/cells.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// The thinned points of all patches with `use`, in the world, one for each cube of `size_m` (0: all of them).
/// `sensor_of[lidar]` goes to MapPoint::sensor. With `every` = n only every nth point of a patch is looked at.
[[nodiscard]] std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                                             const std::vector<char>& use, const std::vector<int>& sensor_of,
                                             double size_m, std::size_t every = 1);

/// The same coarsely, for pictures: a point for each 5 cm, of a quarter of the points.
[[nodiscard]] std::vector<MapPoint> fuse_map_to_look_at(const std::vector<PatchCells>& patches, const RigState& state,
                                                        const std::vector<char>& use,
                                                        const std::vector<int>& sensor_of);

}  // namespace rigcal
