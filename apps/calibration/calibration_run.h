#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "apps/recording/recording.h"
#include "core/quality/result.h"

namespace rigcal {

/// What a result tells of the run that made it.
struct CalibrationRun {
  std::vector<StageReport> reading;  ///< The stages before the calibration.
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> settings;
  std::vector<InputDigest> inputs;
};

/// Completes a result with what the run and the recording tell, and writes it as a folder. Errors: the disk.
Expected<void> write_calibration(const Recording& recording, CalibrationRun run, const std::string& out,
                                 CalibrationResult& result);

/// What `rigcal calibrate SESSION` does after it has read the recording, with its default options. `solved`: see
/// RigCalibrationOptions. Errors: as `calibrate_rig`.
[[nodiscard]] Expected<CalibrationResult> calibrate_by_default(
    const Recording& recording, const RunContext& context,
    const std::function<void(const CalibrationResult&)>& solved = {});

}  // namespace rigcal
