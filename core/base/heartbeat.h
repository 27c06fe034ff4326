#pragma once

#include <atomic>
#include <cstdint>
#include <string>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal {

/// By this a thread shows that it is alive: it beats in each of its rounds, and whoever watches sees when it does not.
/// From any threads; a beat costs one reading of a clock.
class Heartbeat {
 public:
  explicit Heartbeat(std::string name) : name_(std::move(name)) {}

  void beat() {
    const std::int64_t now = monotonic_now_ns();
    const std::int64_t last = last_ns_.exchange(now, std::memory_order_relaxed);
    if (last != 0 && now - last > worst_ns_.load(std::memory_order_relaxed))
      worst_ns_.store(now - last, std::memory_order_relaxed);
  }
  /// The thread is over, or does what may take as long as it likes: no beat is missed.
  void rest() { last_ns_.store(0, std::memory_order_relaxed); }

  [[nodiscard]] const std::string& name() const { return name_; }
  /// Since the last beat; 0 while it rests or has not begun.
  [[nodiscard]] double pause_s() const {
    const std::int64_t last = last_ns_.load(std::memory_order_relaxed);
    return last == 0 ? 0.0 : seconds_of_ns(monotonic_now_ns() - last);
  }
  /// The longest time between two beats.
  [[nodiscard]] std::int64_t worst_ns() const { return worst_ns_.load(std::memory_order_relaxed); }

 private:
  std::string name_;
  std::atomic<std::int64_t> last_ns_{0};
  std::atomic<std::int64_t> worst_ns_{0};
};

}  // namespace rigcal
