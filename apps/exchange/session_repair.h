#pragma once

#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// Finishes a session that was cut short, as by a power cut: cuts packet files after their last whole packet and tables
/// after their last whole line, takes images that are not whole out of the tables, counts the packets anew, and gives
/// session.json its end. Returns what was done, one sentence each; nothing where the session has an end already, which
/// is not touched then. Doing it twice is doing it once. Errors: no session, files that cannot be read or written.
[[nodiscard]] Expected<std::vector<std::string>> repair_session(const std::string& path, const RunContext& context);

}  // namespace rigcal
