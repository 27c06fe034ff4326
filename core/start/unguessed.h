#pragma once

#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// Finds the LiDARs without a guess, and those that fit nowhere near theirs, once the rig's poses are known: each finds
/// the axis that it was carried round by itself, or where the rig drove its mounting (`find_mountings`), and then
/// stands where it meets what the LiDARs found so far have seen. Those that are sure come first and help the others;
/// what rests on one that is not sure is not surer. Sets `matches`, `lidar_known` and the extrinsics.
void place_without_guess(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start);

}  // namespace rigcal
