#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "apps/capture/capture_status.h"

namespace rigcal {

/// The lines that show a running capture on a terminal, at most 79 columns each: what to do now, how far the stop is,
/// the stops, each sensor, the disk, what `calibration` says, and what happened last: a small window shows the first.
[[nodiscard]] std::vector<std::string> dashboard_lines(const CaptureStatus& status,
                                                       const std::vector<std::string>& calibration = {});

/// What happened since `told` events had been told; where it was more than the status holds, the newest.
[[nodiscard]] std::vector<std::string> new_lines(const CaptureStatus& status, std::uint64_t told);

}  // namespace rigcal
