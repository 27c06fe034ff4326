#pragma once

#include "core/pipeline/lidar_calibration.h"

namespace rigcal {

/// The fused map of a solution and the comparison with the guess, into a result that has none yet; its sensors may be
/// more than the LiDARs, in any order.
void add_map(const Rig& rig, const LidarRecording& recording,
             const std::vector<std::optional<SE3>>& guess_T_base_sensor, const LidarCalibrationOptions& options,
             const LidarSolution& solution, CalibrationResult& result);

}  // namespace rigcal
