#pragma once

#include <string>
#include <vector>

#include "core/pipeline/incremental_calibration.h"

namespace rigcal {

/// What `calibrate` says at its end: status first, then every sensor with its sigmas and reasons, and where it lies.
[[nodiscard]] std::string calibration_text(const CalibrationResult& result, const std::string& out);
/// The same as one JSON object, with what was known after each stop where that was asked for;
/// docs/schema/calibrate.json.
[[nodiscard]] std::string calibration_json(const CalibrationResult& result, const std::string& out,
                                           const std::vector<StopEstimate>& estimates);

}  // namespace rigcal
