#pragma once

#include <string_view>

#include "apps/common/exit_code.h"

namespace rigcal {

/// Says these words on stderr and ends the program. Nothing is waited for: no lock, no thread, no terminal that takes
/// nothing.
[[noreturn]] void end_at_once(std::string_view words, ExitCode code);

}  // namespace rigcal
