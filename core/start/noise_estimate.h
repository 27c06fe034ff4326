#pragma once

#include <vector>

#include "core/start/surfels.h"
#include "core/voxel/noise_model.h"

namespace rigcal {

/// The noise law of one LiDAR from the thickness of its own surfels at many ranges and incidences: a mixture of noise
/// and of what is rough, curved or two surfaces, fitted by expectation maximisation from the lower third of each bin on
/// (docs/decisions/033). `fallback` where fewer than 60 surfels or three bins were seen.
[[nodiscard]] NoiseModel estimate_noise(const std::vector<PatchSurfels>& patches, int lidar,
                                        const NoiseModel& fallback);

}  // namespace rigcal
