#pragma once

#include <string>

#include "core/turntable/capture_machine.h"

namespace rigcal {

/// Degrees from one stop to the next, so that the wanted stops make a full turn; 18 where any number will do.
[[nodiscard]] double step_deg(const CaptureProgress& progress);

/// What the operator is to do now, one sentence without a full stop.
[[nodiscard]] std::string advice(const CaptureProgress& progress);

}  // namespace rigcal
