#pragma once

#include <vector>

#include "core/start/surfels.h"
#include "core/voxel/noise_model.h"

namespace rigcal {

/// The noise law of one LiDAR from the thickness of its own surfels at many ranges and incidences. The lower third of
/// each bin stands for it, so that rough surfaces do not count; `fallback` where fewer than 60 surfels or three bins
/// were seen.
[[nodiscard]] NoiseModel estimate_noise(const std::vector<PatchSurfels>& patches, int lidar,
                                        const NoiseModel& fallback);

}  // namespace rigcal
