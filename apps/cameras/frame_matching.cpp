#include "apps/cameras/frame_matching.h"

#include <cmath>
#include <utility>

#include "core/base/error.h"

namespace rigcal {

void FrameMatching::add_frame(FrameRecord frame, const FrameSighting& sighting) {
  waiting_.push_back(std::move(frame));
  matcher_.add_frame(sighting);
}

std::optional<FrameRecord> FrameMatching::next() {
  const std::optional<FrameMatch> match = matcher_.next();
  if (!match) return std::nullopt;
  RIGCAL_ASSERT(!waiting_.empty(), "a frame was decided that never came");
  FrameRecord frame = std::move(waiting_.front());
  waiting_.pop_front();
  if (match->fate == FrameFate::matched) {
    frame.trigger = match->pulse;
    const double middle_us = delay_us_ + 0.5 * frame.exposure_us.value_or(0.0);
    frame.stamp_ns = match->released_ns + std::llround(1e3 * middle_us);
  }
  return frame;
}

}  // namespace rigcal
