#pragma once

#include <string>

#include "core/base/error.h"

namespace rigcal {

/// What may help after a call of the system that gave `code` (an errno), true of files, devices and sockets alike.
/// Whoever knows more of the place says it better. Empty of codes that tell no cause (EINVAL).
[[nodiscard]] std::string mend_of(int code);

/// An Error of kind system: "what: the system's words for `code`"; without a `mend` that of the code.
[[nodiscard]] Error call_error(const std::string& what, int code, std::string where = {}, std::string mend = {});

}  // namespace rigcal
