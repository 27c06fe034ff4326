#include "core/pipeline/rig_calibration.h"

#include <algorithm>

#include "core/pipeline/result_map.h"
#include "core/quality/verdict_text.h"

namespace rigcal {
namespace {

// Of a base that saw nothing cameras are as little known as the LiDARs are, whatever they see of the map.
std::vector<CameraRecording> without_images(std::vector<CameraRecording> cameras, const std::string& why) {
  for (CameraRecording& camera : cameras) {
    camera.read_images = [why](const RunContext&) { return StillImages{{}, why}; };
  }
  return cameras;
}

bool has_failed(const CalibrationResult& result, const std::string& name) {
  return std::any_of(result.sensors.begin(), result.sensors.end(), [&](const SensorResult& sensor) {
    return sensor.name == name && sensor.status == Status::failed;
  });
}

}  // namespace

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
  const bool is_blind = !recording.trajectory_is_prior && has_failed(*result, result->base);
  const std::vector<CameraRecording> seen =
      is_blind ? without_images(cameras, blind_base_words(result->base)) : cameras;
  const Expected<void> added =
      add_cameras(rig, seen, recording, *solution, options.lidars.require, *options.cameras, context, *result, solved);
  if (!added) return added.error();
  return result;
}

}  // namespace rigcal
