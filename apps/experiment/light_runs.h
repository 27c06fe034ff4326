#pragma once

#include <array>
#include <cstdint>

#include "core/pipeline/lidar_calibration.h"
#include "simdata/rig/light_rig.h"

namespace rigcal {

/// The scenes in which experiments on random rigs take turns, by seed.
inline constexpr std::array<const char*, 3> light_run_scenes{"courtyard", "room", "sparse"};

/// The rig of a seed for questions of accuracy: as mounted, 12 to 24 stops, `points` a patch, with units whose ranges
/// are off by `range_bias_m` (sigma) and beams of which `footprint_share` bleeds.
[[nodiscard]] sim::LightRigOptions sigma_run(std::uint64_t seed, int points, double range_bias_m,
                                             double footprint_share);

/// What `calibrate_lidars` takes of a simulated run: every sensor is a LiDAR; the gyro's turns where there is one. The
/// points are given up on the way.
[[nodiscard]] LidarRecording light_recording(sim::LightRig& light, bool with_gyro);

/// Calibrates it as a rig file and a gyro let one: from its rough extrinsics, without a map. Errors: those of
/// `calibrate_lidars`. The points are given up.
[[nodiscard]] Expected<CalibrationResult> calibrate_from_guesses(sim::LightRig& light, const RunContext& context);

}  // namespace rigcal
