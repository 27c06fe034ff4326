#pragma once

#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// Finds the LiDARs without a guess, and those that fit nowhere near theirs, once the rig's poses are known and
/// were a turn about an axis: each finds the axis that it was carried round by itself, and then stands where its
/// panorama meets what the LiDARs found so far have seen. Those that are sure come first and help the others. A place
/// far from a guess must fit clearly better than the best near it. Sets `matches`, `lidar_known` and the extrinsics.
void place_without_guess(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start);

}  // namespace rigcal
