#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/frames/frame_ids.h"
#include "core/frames/pulse_book.h"
#include "core/frames/release_line.h"

namespace rigcal {

/// A frame as it came from a camera.
struct FrameSighting {
  std::uint64_t id = 0;
  std::optional<std::int64_t> device_ns;  ///< By the camera's clock, where it gave a stamp.
  std::int64_t received_ns = 0;           ///< Session time.
};

struct FrameMatcherOptions {
  /// Otherwise the stamps of arrival and the frames' numbers must do; so they must where frames turn out to have none.
  bool has_device_stamps = true;
  FrameIdRule ids;
  /// From a pulse until its frame is there, at the quickest: trigger delay and exposure; nothing comes before.
  std::int64_t least_lag_ns = 0;
  /// The most that this shortest lag may be: add readout and transfer. Where it is less than the distance of the
  /// pulses, the start is never in doubt; otherwise it is decided by how the pulses come: bursts, pauses.
  std::int64_t most_lag_ns = 40'000'000;
  std::int64_t least_interval_ns = 0;  ///< Of two exposures: pulses that come sooner are ignored by the camera.
};

/// Frames may come so much later than the quickest one: resent packets, a busy machine.
inline constexpr std::int64_t late_frame_ns = 150'000'000;

/// The stamp that the line maps.
[[nodiscard]] constexpr std::int64_t line_stamp(const FrameMatcherOptions& options, const FrameSighting& frame) {
  return options.has_device_stamps ? frame.device_ns.value_or(frame.received_ns) : frame.received_ns;
}

/// The pulses that may have released a frame, by the time at which it came: from `first` to before `end` in the book.
struct PulseRange {
  std::size_t first = 0;
  std::size_t end = 0;
};
[[nodiscard]] PulseRange plausible_pulses(const PulseBook& book, const FrameMatcherOptions& options,
                                          const FrameSighting& frame);

/// Which pulse the frames begin with: each possible pair of an early frame and a pulse is followed through all frames,
/// and the one by which frames and pulses agree best is the answer, as a line through its first pair. Nothing where
/// less than half of the frames find a pulse, or where another way to pair them is nearly as good.
[[nodiscard]] std::optional<ReleaseLine> find_start(const PulseBook& book, std::span<const FrameSighting> frames,
                                                    const FrameMatcherOptions& options);

}  // namespace rigcal
