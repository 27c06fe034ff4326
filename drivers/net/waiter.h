#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "core/base/error.h"

namespace rigcal::net {

/// Waits for any of several descriptors, or until another thread wakes it. No memory is asked for after it was made.
class Waiter {
 public:
  static constexpr std::size_t kMost = 64;

  /// Errors: the system gives no descriptor; more than `kMost`.
  [[nodiscard]] static Expected<Waiter> create(const std::vector<int>& descriptors);
  ~Waiter();
  Waiter(Waiter&&) noexcept;
  Waiter& operator=(Waiter&&) noexcept;

  /// True where something can be read (see `is_ready`) or `wake` was called; false when the time is over. A negative
  /// time waits without end.
  bool wait(std::int64_t timeout_ns);
  /// Whether the descriptor of this place in the list had something at the last `wait`.
  [[nodiscard]] bool is_ready(std::size_t index) const;
  /// From any thread: ends the wait that is under way, or the next one.
  void wake() const;

 private:
  struct State;
  explicit Waiter(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace rigcal::net
