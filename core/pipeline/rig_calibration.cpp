#include "core/pipeline/rig_calibration.h"

#include "core/pipeline/result_map.h"

namespace rigcal {

Expected<CalibrationResult> calibrate_rig(const Rig& rig, const LidarRecording& recording,
                                          const std::vector<CameraRecording>& cameras,
                                          const std::vector<std::optional<SE3>>& guess_T_base_lidar,
                                          const RigCalibrationOptions& options, const RunContext& context) {
  const bool all = options.cameras.has_value() && options.lidars.last_stage == LastStage::joint && !cameras.empty();
  LidarCalibrationOptions lidars = options.lidars;
  lidars.with_map = false;
  std::unique_ptr<LidarSolution> solution;
  Expected<CalibrationResult> result = calibrate_lidars(rig, recording, guess_T_base_lidar, lidars, context, &solution);
  if (!result) return result;
  const auto solved = [&] {
    if (options.solved) options.solved(*result);
    context.reporter.progress("map", -1.0);
    add_map(rig, recording, guess_T_base_lidar, options.lidars, *solution, *result);
  };
  if (!all) {
    solved();
    return result;
  }
  const Expected<void> added = add_cameras(rig, cameras, recording, *solution, options.lidars.require, *options.cameras,
                                           context, *result, solved);
  if (!added) return added.error();
  return result;
}

}  // namespace rigcal
