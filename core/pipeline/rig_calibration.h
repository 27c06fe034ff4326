#pragma once

#include <optional>
#include <vector>

#include "core/pipeline/camera_stage.h"
#include "core/pipeline/lidar_calibration.h"

namespace rigcal {

struct RigCalibrationOptions {
  LidarCalibrationOptions lidars;
  std::optional<CameraCalibrationOptions> cameras = CameraCalibrationOptions{};  ///< Nothing: LiDARs only.
};

/// The targetless method for a whole rig: the LiDARs (`calibrate_lidars`, whose errors these are, too), then every
/// camera against their map.
[[nodiscard]] Expected<CalibrationResult> calibrate_rig(const Rig& rig, const LidarRecording& recording,
                                                        const std::vector<CameraRecording>& cameras,
                                                        const std::vector<std::optional<SE3>>& guess_T_base_lidar,
                                                        const RigCalibrationOptions& options,
                                                        const RunContext& context);

}  // namespace rigcal
