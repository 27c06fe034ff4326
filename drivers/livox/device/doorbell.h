#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <semaphore>

namespace rigcal::livox {

/// Wakes one thread that has nothing to do, from others that have found something for it. Costs those nothing while it
/// is busy. No memory is asked for.
class Doorbell {
 public:
  /// The thread is about to wait: what is found from now on rings. Look once more for what was found before.
  void listen() { is_waiting_.store(true); }
  /// Until it rings, at most for that long; only after `listen`.
  void wait(std::int64_t timeout_ns) {
    if (bell_.try_acquire_for(std::chrono::nanoseconds(timeout_ns))) return;
    hush();
  }
  /// In place of a wait, where the second look has found something.
  void hush() {
    if (!is_waiting_.exchange(false)) bell_.acquire();  // Somebody is ringing just now.
  }
  void ring() {
    if (is_waiting_.load() && is_waiting_.exchange(false)) bell_.release();
  }

 private:
  std::atomic<bool> is_waiting_{false};
  std::binary_semaphore bell_{0};
};

}  // namespace rigcal::livox
