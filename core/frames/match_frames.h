#pragma once

#include <optional>
#include <span>
#include <vector>

#include "core/frames/frame_matcher.h"

namespace rigcal {

/// What became of the frames of a camera, and of the pulses of its line.
struct MatchedFrames {
  std::vector<FrameMatch> frames;  ///< As they came.
  MatchLedger ledger;
  std::optional<CameraClockFigures> clock;
};

/// All of a recording at once, the same as while it was taken: pulses in the order of time, frames in that of arrival.
[[nodiscard]] MatchedFrames match_frames(std::span<const TriggerPulse> pulses, std::span<const FrameSighting> frames,
                                         const FrameMatcherOptions& options);

}  // namespace rigcal
