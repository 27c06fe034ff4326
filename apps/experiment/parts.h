#pragma once

#include <algorithm>
#include <string>
#include <vector>

namespace rigcal {

/// Whether a part of an experiment is among those that were asked for; none named: all are.
[[nodiscard]] inline bool is_wanted(const std::string& part, const std::vector<std::string>& parts) {
  return parts.empty() || std::find(parts.begin(), parts.end(), part) != parts.end();
}

}  // namespace rigcal
