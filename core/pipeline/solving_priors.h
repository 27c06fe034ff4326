#pragma once

#include <optional>
#include <vector>

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// What holds the directions that planes leave open: what the start found by shapes, and the poses of the stops. Those
/// that the user gave hold by the sigmas of `options`, and so do the guesses that hang on them, by twice the basin;
/// else the start's. `guess_T_base_sensor` as seen from the LiDAR in whose frame it is solved.
[[nodiscard]] AdjustOptions solving_priors(const LidarRecording& recording, const Start& start,
                                           const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                           const LidarCalibrationOptions& options);

}  // namespace rigcal
