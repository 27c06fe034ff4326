#pragma once

#include <deque>
#include <optional>

#include "core/frames/frame_matcher.h"
#include "core/records/image.h"

namespace rigcal {

/// The lines of frames.csv of a camera that waits for pulses of the rig's own trigger line: each gets its pulse, and
/// the middle of its exposure by that pulse. They wait for that, half a second at most once the start is clear.
class FrameMatching {
 public:
  /// `delay_us`: of the camera, from the edge to its exposure.
  FrameMatching(const FrameMatcherOptions& options, double delay_us) : matcher_(options), delay_us_(delay_us) {}

  /// With the time of the edge at which the camera exposes.
  void add_pulse(const TriggerPulse& pulse) { matcher_.add_pulse(pulse); }
  /// `frame` has the middle of the exposure as well as it is known without a pulse; it keeps it where none is found.
  void add_frame(FrameRecord frame, const FrameSighting& sighting);
  /// It is that late, session time, though nothing came.
  void advance(std::int64_t now_ns) { matcher_.advance(now_ns); }
  /// Nothing more will come.
  void finish() { matcher_.finish(); }
  /// The next line that is decided, in the order in which the frames came.
  [[nodiscard]] std::optional<FrameRecord> next();

  [[nodiscard]] const MatchLedger& ledger() const { return matcher_.ledger(); }
  [[nodiscard]] std::optional<CameraClockFigures> clock() const { return matcher_.clock(); }

 private:
  FrameMatcher matcher_;
  double delay_us_;
  std::deque<FrameRecord> waiting_;
};

}  // namespace rigcal
