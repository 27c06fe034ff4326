#include "core/frames/match_frames.h"

namespace rigcal {

MatchedFrames match_frames(std::span<const TriggerPulse> pulses, std::span<const FrameSighting> frames,
                           const FrameMatcherOptions& options) {
  FrameMatcher matcher(options);
  MatchedFrames matched;
  matched.frames.reserve(frames.size());
  const auto take = [&] {
    while (const auto match = matcher.next()) matched.frames.push_back(*match);
  };
  std::size_t pulse = 0;
  for (const FrameSighting& frame : frames) {
    for (; pulse < pulses.size() && pulses[pulse].stamp_ns <= frame.received_ns; ++pulse)
      matcher.add_pulse(pulses[pulse]);
    matcher.add_frame(frame);
    take();
  }
  for (; pulse < pulses.size(); ++pulse) matcher.add_pulse(pulses[pulse]);
  matcher.finish();
  take();
  matched.ledger = matcher.ledger();
  matched.clock = matcher.clock();
  return matched;
}

}  // namespace rigcal
