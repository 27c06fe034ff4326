#pragma once

#include <cstdint>
#include <span>

#include "drivers/trigger/gpio_line.h"

namespace rigcal::trigger {

/// Mends which way edges went. The kernel stamps an edge when it happens, but looks at the line's level only when its
/// thread gets to run: where that is after the pulse's end, the rising edge is reported as a second falling one.
class EdgeLevels {
 public:
  /// Edges in their order. After a gap in their numbers, and at first, the kernel is believed.
  void mend(std::span<Edge> edges) {
    for (Edge& edge : edges) {
      const bool is_after_gap = last_sequence_ > 0 && edge.sequence > last_sequence_ + 1;
      if (level_ == Level::low && !is_after_gap && !edge.is_rising) {
        edge.is_rising = true;
        ++mended_;
      }
      // A rising edge while the line is high stays one: its falling edge is lost, and the next one is right again.
      level_ = edge.is_rising ? Level::high : Level::low;
      last_sequence_ = edge.sequence;
    }
  }
  /// The line was let go and is held anew.
  void forget() {
    level_ = Level::unknown;
    last_sequence_ = 0;
  }
  [[nodiscard]] std::uint64_t mended() const { return mended_; }

 private:
  enum class Level { unknown, low, high };
  Level level_ = Level::unknown;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t mended_ = 0;
};

}  // namespace rigcal::trigger
