#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Finishes a session that was cut short, as by a power cut: cuts packet files after their last whole packet and tables
/// after their last whole line, takes images that are not whole out of the tables, counts the packets anew, and gives
/// session.json its end. No more is thrown away than a power cut tears: where more follows the last whole packet, it is
/// kept beside the file. Returns what was done, one sentence each; nothing where the session has an end already, which
/// is not touched then. Doing it twice is doing it once. Errors: no session, one that is still being recorded, files
/// that cannot be read or written, no room for what must be kept; what was done before the error is told as warnings.
[[nodiscard]] Expected<std::vector<std::string>> repair_session(const std::string& path, const RunContext& context);

}  // namespace rigcal
