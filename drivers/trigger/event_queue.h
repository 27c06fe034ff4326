#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <vector>

#include "drivers/trigger/trigger_event.h"

namespace rigcal::trigger {

/// Events of several threads for one that takes them, in the order in which they came. Its memory is asked for once; an
/// event for which there is no room is dropped and counted.
class EventQueue {
 public:
  explicit EventQueue(std::size_t capacity) : events_(capacity) {}

  void push(const TriggerEvent& event) {
    {
      const std::lock_guard lock(mutex_);
      if (size_ == events_.size()) {
        ++dropped_;
        return;
      }
      events_[(first_ + size_) % events_.size()] = event;
      high_water_ = std::max(high_water_, ++size_);
    }
    filled_.notify_one();
  }

  /// The oldest event, for which it waits at most that long; false where none came, or nothing will any more.
  bool take(TriggerEvent& event, std::int64_t timeout_ns) {
    std::unique_lock lock(mutex_);
    filled_.wait_for(lock, std::chrono::nanoseconds(timeout_ns), [this] { return size_ > 0 || is_closed_; });
    if (size_ == 0) return false;
    event = events_[first_];
    first_ = (first_ + 1) % events_.size();
    --size_;
    return true;
  }

  /// Nothing more will come: who waits need not.
  void close() {
    {
      const std::lock_guard lock(mutex_);
      is_closed_ = true;
    }
    filled_.notify_all();
  }

  [[nodiscard]] std::size_t capacity() const { return events_.size(); }
  /// Most events that have waited at once.
  [[nodiscard]] std::size_t high_water() const {
    const std::lock_guard lock(mutex_);
    return high_water_;
  }
  [[nodiscard]] std::uint64_t dropped() const {
    const std::lock_guard lock(mutex_);
    return dropped_;
  }

 private:
  mutable std::mutex mutex_;
  std::condition_variable filled_;
  std::vector<TriggerEvent> events_;
  std::size_t first_ = 0;
  std::size_t size_ = 0;
  std::size_t high_water_ = 0;
  std::uint64_t dropped_ = 0;
  bool is_closed_ = false;
};

}  // namespace rigcal::trigger
