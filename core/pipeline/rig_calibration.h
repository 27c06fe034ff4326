#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "core/pipeline/camera_stage.h"
#include "core/pipeline/lidar_calibration.h"

namespace rigcal {

struct RigCalibrationOptions {
  LidarCalibrationOptions lidars;
  std::optional<CameraCalibrationOptions> cameras = CameraCalibrationOptions{};  ///< Nothing: LiDARs only.
  /// Called once all numbers stand: extrinsics, sigmas, verdicts, poses. What is for the eye (map, comparison with the
  /// guess, colours) comes after it, and takes as long again. May be empty.
  std::function<void(const CalibrationResult&)> solved = {};
};

/// The targetless method for a whole rig: the LiDARs (`calibrate_lidars`, whose errors these are, too), then every
/// camera against their map.
[[nodiscard]] Expected<CalibrationResult> calibrate_rig(const Rig& rig, const LidarRecording& recording,
                                                        const std::vector<CameraRecording>& cameras,
                                                        const std::vector<std::optional<SE3>>& guess_T_base_lidar,
                                                        const RigCalibrationOptions& options,
                                                        const RunContext& context);

}  // namespace rigcal
