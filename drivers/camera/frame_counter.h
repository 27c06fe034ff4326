#pragma once

#include <cstdint>

#include "core/frames/frame_ids.h"

namespace rigcal::camera {

/// Tells from a camera's frame ids how many frames never came.
class FrameCounter {
 public:
  /// More at once were not lost: the camera counts anew.
  static constexpr std::int64_t kLongestGap = 100'000;

  explicit FrameCounter(const FrameIdRule& rule) : rule_(rule) {}

  /// How many are missing between the frame before and this one. A frame that comes late, or a second time, is none;
  /// a camera that began anew counts from there.
  [[nodiscard]] std::uint64_t missing_before(std::uint64_t id) {
    const bool is_strange = rule_.bits < 64 && id >> static_cast<unsigned>(rule_.bits) != 0;
    if (is_strange) return 0;
    const std::int64_t steps = has_begun_ ? frame_steps(rule_, before_, id) : 1;
    if (steps > 0 || id <= 1) before_ = id;
    has_begun_ = true;
    return steps > 1 && steps <= kLongestGap ? static_cast<std::uint64_t>(steps - 1) : 0;
  }

 private:
  FrameIdRule rule_;
  std::uint64_t before_ = 0;
  bool has_begun_ = false;
};

}  // namespace rigcal::camera
