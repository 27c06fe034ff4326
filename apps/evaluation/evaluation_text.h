#pragma once

#include <optional>
#include <string>

#include "apps/evaluation/evaluation.h"

namespace rigcal {

/// An evaluation as a table for people.
[[nodiscard]] std::string evaluation_text(const Evaluation& evaluation);

/// The same as one JSON object (docs/schema/evaluate.json); `within` only where bounds were given.
[[nodiscard]] std::string evaluation_json(const Evaluation& evaluation, std::optional<bool> within);

}  // namespace rigcal
