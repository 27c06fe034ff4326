#pragma once

#include <string>

#include "core/quality/result.h"

namespace rigcal {

/// The evidence of every camera as a JSON array, for report.json (`cameras` in docs/schema/report.json).
[[nodiscard]] std::string cameras_json(const CalibrationResult& result);

/// "{model: radtan, width: ...}", as a rig file may have it.
[[nodiscard]] std::string intrinsics_text(const CameraIntrinsics& intrinsics);

}  // namespace rigcal
