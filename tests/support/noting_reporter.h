#pragma once

#include <string>
#include <utility>
#include <vector>

#include "core/base/run_context.h"

namespace rigcal {

/// A Reporter that keeps the warnings.
class NotingReporter final : public Reporter {
 public:
  void progress(std::string_view, double) override {}
  void warn(std::string message) override { warnings.push_back(std::move(message)); }
  void debug(std::string) override {}
  std::vector<std::string> warnings;
};

}  // namespace rigcal
