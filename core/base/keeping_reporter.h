#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "core/base/run_context.h"

namespace rigcal {

/// Passes everything on, and keeps the warnings as well, for a result.
class KeepingReporter final : public Reporter {
 public:
  /// `to` must outlive it.
  explicit KeepingReporter(Reporter& to) : to_(to) {}
  void progress(std::string_view stage, double fraction) override { to_.progress(stage, fraction); }
  void warn(std::string message) override {
    {
      const std::lock_guard lock(mutex_);
      warnings_.push_back(message);
    }
    to_.warn(std::move(message));
  }
  void debug(std::string message) override { to_.debug(std::move(message)); }

  /// Those so far; they are not kept any longer.
  [[nodiscard]] std::vector<std::string> take() {
    const std::lock_guard lock(mutex_);
    return std::exchange(warnings_, {});
  }

 private:
  Reporter& to_;
  std::mutex mutex_;
  std::vector<std::string> warnings_;
};

}  // namespace rigcal
