#pragma once

#include <cstdint>
#include <optional>

namespace rigcal::camera {

/// Tells from a camera's frame ids how many frames never came. Ids go up by one from `first` to `last` and begin again
/// at `first`.
class FrameCounter {
 public:
  FrameCounter(std::uint64_t first, std::uint64_t last) : first_(first), last_(last) {}

  /// How many are missing between the frame before and this one. A frame that comes late, or a second time, is none; a
  /// camera that began anew counts from there.
  [[nodiscard]] std::uint64_t missing_before(std::uint64_t id) {
    const std::optional<std::uint64_t> before = before_;
    if (id < first_ || id > last_) return 0;
    if (!before) {
      before_ = id;
      return 0;
    }
    const std::uint64_t steps = id >= *before ? id - *before : last_ - *before + (id - first_) + 1;
    // More than half a round on is a step back.
    if (steps == 0 || steps > (last_ - first_) / 2 + 1) {
      if (id == first_) before_ = id;
      return 0;
    }
    before_ = id;
    return steps - 1;
  }
  /// The camera begins anew.
  void restart() { before_.reset(); }

 private:
  std::uint64_t first_;
  std::uint64_t last_;
  std::optional<std::uint64_t> before_;
};

}  // namespace rigcal::camera
