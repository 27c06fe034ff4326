#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/recording/session_counters.h"
#include "core/base/heartbeat.h"

namespace rigcal {

/// Sees which threads of the program do not move any more.
class ThreadWatch {
 public:
  static constexpr double kStuckS = 3.0;

  /// The heartbeats must outlive it.
  explicit ThreadWatch(std::vector<const Heartbeat*> threads) : threads_(std::move(threads)) {}

  struct News {
    std::string thread;
    std::string text;
  };
  /// What changed since the last call.
  [[nodiscard]] std::vector<News> look();
  /// As of the last look.
  [[nodiscard]] const std::vector<std::string>& stuck() const { return stuck_; }
  /// The longest pause of each.
  void count(SessionCounters& counters) const;

 private:
  std::vector<const Heartbeat*> threads_;
  std::vector<std::string> stuck_;
};

}  // namespace rigcal
