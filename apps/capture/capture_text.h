#pragma once

#include <string>
#include <vector>

#include "apps/calibration/live_result.h"
#include "apps/capture/capture_summary.h"

namespace rigcal {

/// How a running capture does, for a terminal of 80 columns: a line of its own, a table with a line for each LiDAR, and
/// a line for each that says that something is wrong.
[[nodiscard]] std::vector<std::string> capture_lines(const CaptureStatus& status);

[[nodiscard]] std::string capture_text(const CaptureSummary& summary);
/// As docs/schema/capture.json has it. `calibration`: of a capture that calibrated as it went; may be null.
[[nodiscard]] std::string capture_json(const CaptureSummary& summary, const LiveResult* calibration = nullptr);

}  // namespace rigcal
