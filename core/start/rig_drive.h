#pragma once

#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// The surfels of all LiDARs that are known as if the base had seen them, a patch a stop.
[[nodiscard]] std::vector<PatchSurfels> seen_by_rig(const StartInput& input, const std::vector<PatchSurfels>& patches,
                                                    const Start& start);

/// What one LiDAR saw from a stop may slide along a wall of what it saw before, and all later stops with it; it may
/// even have been taken for a turn in place. Together the LiDARs see more sides: where laying all that they saw on
/// itself gives other poses that fit it better, these are taken. True then.
[[nodiscard]] bool drive_with_all(const StartInput& input, const std::vector<PatchSurfels>& patches, Start& start);

}  // namespace rigcal
