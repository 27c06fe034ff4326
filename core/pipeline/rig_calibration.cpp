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

// No rig is as wide, and what was written in millimetres lies farther away. LiDARs are found all the same, cameras not.
constexpr double far_guess_m = 10.0;

void warn_of_far_guess(const Rig& rig, int sensor, const std::optional<SE3>& guess, Reporter& reporter) {
  if (!guess || guess->t.norm() <= far_guess_m) return;
  reporter.warn("the rough pose of " + rig.sensors[static_cast<std::size_t>(sensor)].name + " is " +
                number(guess->t.norm(), 1) + " m from " + rig.base_sensor().name +
                ": initial_extrinsics are in metres; were these millimetres?");
}

void warn_of_far_guesses(const Rig& rig, const LidarRecording& recording, const std::vector<CameraRecording>& cameras,
                         const std::vector<std::optional<SE3>>& guess_T_base_lidar, Reporter& reporter) {
  for (std::size_t i = 0; i < guess_T_base_lidar.size() && i < recording.lidar_sensors.size(); ++i)
    warn_of_far_guess(rig, recording.lidar_sensors[i], guess_T_base_lidar[i], reporter);
  for (const CameraRecording& camera : cameras)
    warn_of_far_guess(rig, camera.sensor, camera.guess_T_base_camera, reporter);
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
  warn_of_far_guesses(rig, recording, cameras, guess_T_base_lidar, context.reporter);
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
