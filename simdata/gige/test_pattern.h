#pragma once

#include "simdata/gige/frame_source.h"

namespace rigcal::sim {

/// Diagonal stripes that move on with each frame, so that every pixel of a frame differs from the one before: a frame
/// made of parts of two is told from a whole one.
class TestPattern final : public FrameSource {
 public:
  bool make(const FrameWish& wish, std::vector<std::uint8_t>& out) override;

  /// The value of a pixel of a frame; `x` and `y` on the sensor, `bits` of its format.
  [[nodiscard]] static std::uint16_t value(std::uint64_t frame, int x, int y, int bits) {
    const auto place = static_cast<std::uint64_t>(x) + 3 * static_cast<std::uint64_t>(y) + 5 * frame;
    return static_cast<std::uint16_t>(place & ((1U << static_cast<unsigned>(bits)) - 1U));
  }
};

}  // namespace rigcal::sim
