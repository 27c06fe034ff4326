#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/clocks/device_clock.h"
#include "core/frames/match_trial.h"

namespace rigcal {

enum class FrameFate {
  matched,        ///< Released by the pulse.
  doubled,        ///< One more frame of a pulse that has one: the camera saw it twice.
  without_pulse,  ///< No pulse is known that could have released it.
  doubtful,       ///< More than one pulse could have released it, or numbers and times contradict each other.
  stray,          ///< Its stamp fits neither what came before nor what followed.
};

/// What became of a frame.
struct FrameMatch {
  FrameSighting frame;
  FrameFate fate = FrameFate::doubtful;
  std::optional<std::int64_t> pulse;  ///< Its number, where it is matched.
  /// When the pulse came, or would have come, that released the frame, session time. The middle of the exposure is the
  /// camera's trigger delay and half its exposure time later.
  std::int64_t released_ns = 0;
  double error_ns = 0.0;  ///< Standard deviation of that beside the pulse's own stamp: 0 where it is matched.
};

/// The book of a camera and its trigger line. All frames: matched + doubled + without_pulse + doubtful + strays + those
/// that wait. All pulses: matched + pulses_without_frame + pulses_too_soon + those that may still get a frame.
struct MatchLedger {
  static constexpr std::size_t kListed = 100;

  std::uint64_t frames = 0;
  std::uint64_t matched = 0;
  std::uint64_t doubled = 0;
  std::uint64_t without_pulse = 0;
  std::uint64_t doubtful = 0;
  std::uint64_t strays = 0;
  std::uint64_t pulses = 0;
  std::uint64_t pulses_without_frame = 0;
  std::uint64_t pulses_too_soon = 0;        ///< While the camera could not expose again yet.
  std::uint64_t pulses_out_of_order = 0;    ///< Not later than the one before: not taken, in none of the others.
  std::uint64_t frames_lost = 0;            ///< Missing numbers of frames: exposed, but never came.
  std::uint64_t id_jumps = 0;               ///< Numbers that went back or too far: the camera counts anew.
  std::uint64_t restarts = 0;               ///< Times the mapping of the camera's clock was found anew.
  std::vector<std::int64_t> listed_pulses;  ///< The first that have no frame.
};

/// The mapping of the camera's clock to session time, less the constant delay from pulse to stamp.
struct CameraClockFigures {
  double drift_ppm = 0.0;  ///< Positive: the camera's clock runs fast.
  double jitter_ns = 0.0;  ///< Standard deviation of its stamps.
  double error_ns = 0.0;   ///< Of the mapping at the last frame, standard deviation, jitter included.
  std::size_t pairs = 0;   ///< Frames that it was learnt from.
};

/// Gives each frame of a camera the pulse that released it. Frames and pulses may be lost anywhere, doubled, or ignored
/// by the camera; its clock may drift and be set; its numbers may wrap and start again. A frame that could be of two
/// pulses is of none: what is matched is right. By the stamps of the camera where it gives any, and then its numbers
/// only tell what was lost; otherwise by arrival and numbers together.
///
/// Streaming: pulses and frames each in their order, in any interleaving; after each call of `add_frame`, `next` is to
/// be called until it gives nothing. Frames are decided in their order, at once where the pulse is known and clear, and
/// after half a second at the latest; while the start is in doubt, they wait, `kWaiting` at most. Memory is bounded,
/// and none is asked for once the start is found. One thread; all times session time.
class FrameMatcher {
 public:
  static constexpr std::size_t kWaiting = 256;

  explicit FrameMatcher(const FrameMatcherOptions& options);

  void add_pulse(const TriggerPulse& pulse);
  void add_frame(const FrameSighting& frame);
  /// It is that late, though nothing came.
  void advance(std::int64_t now_ns);
  /// Nothing more will come: `next` decides all that waits.
  void finish() { is_finished_ = true; }
  /// The next frame that is decided.
  [[nodiscard]] std::optional<FrameMatch> next();

  [[nodiscard]] const MatchLedger& ledger() const { return ledger_; }
  /// Nothing while the start is in doubt.
  [[nodiscard]] std::optional<CameraClockFigures> clock() const;

 private:
  struct Waiting {
    FrameSighting frame;
    bool stray = false;
    bool jumped = false;
  };

  void go_without_stamps();
  void count_ids(const FrameSighting& frame);
  [[nodiscard]] std::size_t frames_until_jump() const;
  void look_for_start(std::size_t frames);
  [[nodiscard]] std::optional<FrameMatch> decide_without_line();
  [[nodiscard]] std::optional<FrameMatch> decide_by_line();
  [[nodiscard]] FrameFate fate_of(const FrameSighting& frame, const PulseChoice& choice);
  [[nodiscard]] bool is_patience_over(const FrameSighting& frame) const;
  [[nodiscard]] FrameMatch pop(FrameFate fate, const StampEstimate& released, std::optional<std::int64_t> pulse = {});
  [[nodiscard]] StampEstimate released_by_arrival(const FrameSighting& frame) const;
  void watch_line(const FrameSighting& frame, FrameFate fate);
  void settle_pulses();
  void settle_first_pulse();

  FrameMatcherOptions options_;
  PulseBook book_;
  std::vector<Waiting> waiting_;
  std::vector<FrameSighting> tried_frames_;
  DeviceClock clock_;
  std::optional<ReleaseLine> line_;
  IdWitness witness_;
  MatchLedger ledger_;
  std::optional<std::uint64_t> last_id_;
  std::int64_t now_ns_ = 0;
  std::int64_t last_pulse_ns_ = 0;
  std::int64_t last_released_ns_ = 0;  ///< The last pulse that was settled with a frame.
  std::int64_t last_stamp_ = 0;        ///< Of the last frame that was decided by the line.
  std::size_t pulses_since_frame_ = 0;
  std::size_t tried_with_ = 0;  ///< Frames with which no start was found.
  int misses_ = 0;              ///< Frames in a row that found no pulse although there were some.
  bool has_released_ = false;
  bool is_finished_ = false;
};

}  // namespace rigcal
