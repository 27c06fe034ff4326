#pragma once

#include "core/quality/result.h"

namespace rigcal {

/// A result with a good base, a weak sensor with numbers that need all digits, and a failed one.
[[nodiscard]] CalibrationResult make_result();

}  // namespace rigcal
