#pragma once

#include <vector>

#include "core/start/stop_poses.h"

namespace rigcal {

/// Lays everything that the known LiDARs saw at the known stops on each other. What holds a stop or a LiDAR holds it
/// where it stands: a turn that closes only with what the others saw, or a chain of stops that drifted, comes right in
/// steps, of `most` at most. Poses that were given are left no further than once. `from_m`: how far off they may be.
void align_all(const StartInput& input, const std::vector<PatchSurfels>& patches, double from_m, const StopHold& hold,
               int most, Start& start);

}  // namespace rigcal
