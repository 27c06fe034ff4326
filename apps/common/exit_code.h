#pragma once

#include "core/base/error.h"
#include "core/quality/result.h"

namespace rigcal {

/// How every command of `rigcal` ends; the numbers are promised to scripts.
enum class ExitCode : int {
  good = 0,
  not_trustworthy = 1,  ///< A sensor is weak or failed, the capture is incomplete, or the user stopped the work.
  usage = 2,            ///< The command line is wrong.
  input = 3,            ///< An input is missing, unreadable, damaged or contradictory.
  system = 4,           ///< A device, the network or the system refused.
};

[[nodiscard]] ExitCode exit_code_of(const Error& error);
/// Good only when the status is good.
[[nodiscard]] ExitCode exit_code_of(Status status);

}  // namespace rigcal
