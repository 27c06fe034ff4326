#pragma once

#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace rigcal {

/// Working memory that parallel loops hand on from round to round: fresh memory costs more than what is done in it. As
/// many items as are ever held at once.
template <class Item>
class SparePool {
 public:
  /// One that was given back, else a new one of these arguments.
  template <class... Arguments>
  [[nodiscard]] std::unique_ptr<Item> take(Arguments&&... arguments) {
    const std::lock_guard lock(mutex_);
    if (spare_.empty()) return std::make_unique<Item>(std::forward<Arguments>(arguments)...);
    std::unique_ptr<Item> item = std::move(spare_.back());
    spare_.pop_back();
    return item;
  }
  void give_back(std::unique_ptr<Item> item) {
    const std::lock_guard lock(mutex_);
    spare_.push_back(std::move(item));
  }

 private:
  std::mutex mutex_;
  std::vector<std::unique_ptr<Item>> spare_;
};

}  // namespace rigcal
