#pragma once

#include <array>
#include <cstdint>

#include "core/pipeline/lidar_calibration.h"
#include "simdata/light_rig.h"

namespace rigcal {

/// The scenes in which experiments on random rigs take turns, by seed.
inline constexpr std::array<const char*, 3> light_run_scenes{"courtyard", "room", "sparse"};

/// What `calibrate_lidars` takes of a simulated run: every sensor is a LiDAR; the gyro's turns where there is one. The
/// points are given up on the way.
[[nodiscard]] LidarRecording light_recording(sim::LightRig& light, bool with_gyro);

}  // namespace rigcal
