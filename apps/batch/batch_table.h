#pragma once

#include <string>

#include "apps/batch/batch_run.h"

namespace rigcal::batch {

/// Fills a row from its result folder and record. A result that cannot be read makes the session failed.
void complete_row(SessionRow& row);

/// One line a session and sensor (RFC 4180), a header first; a session without a result has one line.
[[nodiscard]] std::string batch_csv(const BatchOutcome& outcome);
/// docs/schema/batch.json.
[[nodiscard]] std::string batch_json(const BatchOutcome& outcome, const std::string& out);
/// For people: how many, and those that are not good.
[[nodiscard]] std::string batch_text(const BatchOutcome& outcome, const std::string& out);

}  // namespace rigcal::batch
