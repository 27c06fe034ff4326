#pragma once

#include "core/pipeline/lidar_calibration.h"
#include "core/planes/refine.h"
#include "core/start/rig_start.h"

namespace rigcal {

/// Where the calibration ended.
struct LidarSolution {
  Start start;
  RigState state;
  ParameterLayout layout;
  AdjustOptions adjust;
  RefineSummary refined;
  std::vector<char> use;  ///< Patches that took part.
  std::vector<NoiseModel> noise;
  double unevenness_m = 0.0;  ///< What the surfaces are not, beyond noise; 0: planes as good as their noise.
};

/// Covariances, hold-out and verdict of every LiDAR of the rig, and the poses of the stops. Everything of the result
/// but stages, warnings and map.
[[nodiscard]] CalibrationResult judge_solution(const Rig& rig, const LidarRecording& recording, int base_lidar,
                                               const std::vector<std::optional<SE3>>& guess_T_base_sensor,
                                               const LidarCalibrationOptions& options, const LidarSolution& solution);

}  // namespace rigcal
