#include "apps/calibration/calibration_run.h"

#include "apps/recording/rig_lidars.h"
#include "core/report/result_folder.h"

namespace rigcal {

Expected<void> write_calibration(const Recording& recording, CalibrationRun run, const std::string& out,
                                 CalibrationResult& result) {
  result.stages.insert(result.stages.begin(), run.reading.begin(), run.reading.end());
  result.warnings = std::move(run.warnings);
  result.packets = recording.packets;
  result.clocks = recording.clocks;
  result.settings = std::move(run.settings);
  result.inputs = std::move(run.inputs);
  return write_result_folder(result, out, &recording.rig);
}

Expected<CalibrationResult> calibrate_by_default(const Recording& recording, const RunContext& context,
                                                 const std::function<void(const CalibrationResult&)>& solved) {
  RigCalibrationOptions options;
  options.solved = solved;
  return calibrate_rig(recording.rig, recording.lidar, recording.cameras, lidar_guesses(recording.rig), options,
                       context);
}

}  // namespace rigcal
