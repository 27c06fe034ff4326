#pragma once

#include <string>

#include "core/quality/result.h"

namespace rigcal {

/// What `calibrate` says at its end: status first, then every sensor with its sigmas and reasons, and where it lies.
[[nodiscard]] std::string calibration_text(const CalibrationResult& result, const std::string& out);
/// The same as one JSON object; docs/schema/calibrate.json.
[[nodiscard]] std::string calibration_json(const CalibrationResult& result, const std::string& out);

}  // namespace rigcal
