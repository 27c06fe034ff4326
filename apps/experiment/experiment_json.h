#pragma once

#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "core/base/version.h"

namespace rigcal {

/// What the summary of every experiment begins with.
[[nodiscard]] inline nlohmann::ordered_json experiment_head(const char* experiment) {
  return {{"rigcal", format_version}, {"command", "experiment"}, {"experiment", experiment}};
}

}  // namespace rigcal
