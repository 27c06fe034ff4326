#include "core/frames/frame_matcher.h"

#include <algorithm>
#include <cmath>

#include "core/base/error.h"
#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

// How long after a frame has come the record of its pulse may come.
constexpr std::int64_t patience_ns = 500'000'000;

constexpr std::size_t frames_of_start = 8;
constexpr std::int64_t start_wait_ns = 2'000'000'000;  // Then fewer frames must do.
constexpr std::int64_t pulse_wait_ns = 1'000'000'000;  // Pulses stay open so long beyond the latest possible frame.
constexpr int misses_of_lost_line = 8;
constexpr std::size_t id_slack = 16;  // So many more frames than pulses may have been exposed between two that came.
constexpr std::int64_t most_ns = std::int64_t{1} << 62U;  // Session times are within these: some 140 years.

std::int64_t bounded(std::int64_t stamp_ns) { return std::clamp<std::int64_t>(stamp_ns, 0, most_ns); }

}  // namespace

FrameMatcher::FrameMatcher(const FrameMatcherOptions& options) : options_(options), witness_(options.ids) {
  waiting_.reserve(kWaiting);
  tried_frames_.reserve(kWaiting);
  ledger_.listed_pulses.reserve(MatchLedger::kListed);
}

void FrameMatcher::add_pulse(const TriggerPulse& pulse) {
  const TriggerPulse taken{pulse.pulse, bounded(pulse.stamp_ns)};
  if (ledger_.pulses > 0 && taken.stamp_ns <= last_pulse_ns_) {
    ++ledger_.pulses_out_of_order;
    return;
  }
  ++ledger_.pulses;
  ++pulses_since_frame_;
  last_pulse_ns_ = taken.stamp_ns;
  advance(taken.stamp_ns);
  if (book_.is_full()) settle_first_pulse();
  book_.add(taken);
}

void FrameMatcher::add_frame(const FrameSighting& frame) {
  RIGCAL_ASSERT(waiting_.size() < kWaiting, "a frame more than can wait: next() was not called");
  Waiting waiting{frame, false, false};
  waiting.frame.received_ns = bounded(frame.received_ns);
  if (options_.has_device_stamps && !frame.device_ns && !line_) go_without_stamps();
  if (options_.has_device_stamps && frame.device_ns) {
    const SessionStamp stamp = clock_.add(*frame.device_ns, waiting.frame.received_ns);
    waiting.stray = stamp.stray;
    waiting.jumped = stamp.jumped;
  } else if (options_.has_device_stamps) {
    waiting.stray = true;
  }
  ++ledger_.frames;
  count_ids(frame);
  pulses_since_frame_ = 0;
  advance(waiting.frame.received_ns);
  waiting_.push_back(waiting);
}

// The camera only said that it stamps its frames. Those that wait are looked at anew.
void FrameMatcher::go_without_stamps() {
  options_.has_device_stamps = false;
  for (Waiting& waiting : waiting_) waiting.stray = waiting.jumped = false;
  tried_with_ = 0;
}

void FrameMatcher::advance(std::int64_t now_ns) { now_ns_ = std::max(now_ns_, bounded(now_ns)); }

void FrameMatcher::count_ids(const FrameSighting& frame) {
  if (last_id_) {
    const std::int64_t steps = frame_steps(options_.ids, *last_id_, frame.id);
    if (steps < 1 || static_cast<std::uint64_t>(steps) > pulses_since_frame_ + id_slack) {
      ++ledger_.id_jumps;
    } else {
      ledger_.frames_lost += static_cast<std::uint64_t>(steps - 1);
    }
  }
  last_id_ = frame.id;
}

std::optional<FrameMatch> FrameMatcher::next() {
  if (waiting_.empty()) {
    settle_pulses();
    return std::nullopt;
  }
  Waiting& front = waiting_.front();
  if (front.jumped) {
    front.jumped = false;
    line_.reset();
    tried_with_ = 0;
  }
  if (front.stray) return pop(FrameFate::stray, released_by_arrival(front.frame));
  if (!line_) {
    const std::size_t frames = frames_until_jump();
    look_for_start(frames);
    if (!line_) return decide_without_line();
  }
  return decide_by_line();
}

std::size_t FrameMatcher::frames_until_jump() const {
  for (std::size_t i = 1; i < waiting_.size(); ++i)
    if (waiting_[i].jumped) return i;
  return waiting_.size();
}

void FrameMatcher::look_for_start(std::size_t frames) {
  const bool is_last_try = is_finished_ || frames < waiting_.size();
  const bool is_alone = frames < frames_of_start && now_ns_ > waiting_.front().frame.received_ns + start_wait_ns;
  const bool is_due = frames >= tried_with_ + frames_of_start || ((is_last_try || is_alone) && frames > tried_with_);
  if (!is_due) return;
  tried_with_ = frames;
  tried_frames_.clear();
  for (std::size_t i = 0; i < frames; ++i)
    if (!waiting_[i].stray) tried_frames_.push_back(waiting_[i].frame);
  line_ = find_start(book_, tried_frames_, options_);
  if (!line_) return;
  ++ledger_.restarts;
  tried_with_ = 0;
  misses_ = 0;
  witness_ = IdWitness(options_.ids);
}

bool FrameMatcher::is_patience_over(const FrameSighting& frame) const {
  return is_finished_ || now_ns_ - frame.received_ns >= patience_ns;
}

std::optional<FrameMatch> FrameMatcher::decide_without_line() {
  const FrameSighting& frame = waiting_.front().frame;
  const PulseRange range = plausible_pulses(book_, options_, frame);
  const bool has_pulses = range.first < range.end;
  const bool must_go = is_finished_ || waiting_.size() == kWaiting || frames_until_jump() < waiting_.size();
  if (!must_go && (has_pulses || !is_patience_over(frame))) return std::nullopt;
  // The ones behind it are tried again when there are as many more.
  if (tried_with_ > 0) --tried_with_;
  return pop(has_pulses ? FrameFate::doubtful : FrameFate::without_pulse, released_by_arrival(frame));
}

std::optional<FrameMatch> FrameMatcher::decide_by_line() {
  const FrameSighting frame = waiting_.front().frame;
  last_stamp_ = line_stamp(options_, frame);
  const StampEstimate estimate = line_->at(last_stamp_);
  const PulseChoice choice = book_.choose(estimate);
  const bool is_clear = choice.verdict == PulseChoice::Verdict::clear;
  const double beyond = static_cast<double>(last_pulse_ns_) - static_cast<double>(estimate.stamp_ns);
  if (!is_clear && beyond < PulseBook::reach_ns(estimate) && !is_patience_over(frame)) return std::nullopt;
  const FrameFate fate = fate_of(frame, choice);
  watch_line(frame, fate);
  if (fate != FrameFate::matched) return pop(fate, estimate);
  const TriggerPulse& pulse = book_.pulse(choice.index);
  book_.take(choice.index);
  line_->add(last_stamp_, pulse.stamp_ns);
  return pop(fate, {pulse.stamp_ns, 0.0}, pulse.pulse);
}

FrameFate FrameMatcher::fate_of(const FrameSighting& frame, const PulseChoice& choice) {
  if (choice.verdict == PulseChoice::Verdict::none) return FrameFate::without_pulse;
  if (choice.verdict == PulseChoice::Verdict::several) return FrameFate::doubtful;
  if (book_.is_taken(choice.index)) return FrameFate::doubled;
  if (!options_.has_device_stamps && !witness_.agrees(frame.id, book_.pulse(choice.index).pulse))
    return FrameFate::doubtful;
  return FrameFate::matched;
}

// A camera's clock that was set by less than DeviceClock takes for a jump shows in frames that find no pulse any more.
void FrameMatcher::watch_line(const FrameSighting& frame, FrameFate fate) {
  if (fate == FrameFate::matched) misses_ = 0;
  if (fate != FrameFate::without_pulse) return;
  const PulseRange range = plausible_pulses(book_, options_, frame);
  if (range.first < range.end && ++misses_ >= misses_of_lost_line) {
    line_.reset();
    tried_with_ = 0;
  }
}

StampEstimate FrameMatcher::released_by_arrival(const FrameSighting& frame) const {
  // Somewhere between the quickest way and a late one; uniform.
  const std::int64_t latest = frame.received_ns - options_.least_lag_ns;
  const std::int64_t earliest = frame.received_ns - options_.most_lag_ns - late_frame_ns;
  return {earliest + (latest - earliest) / 2, static_cast<double>(latest - earliest) / std::sqrt(12.0)};
}

FrameMatch FrameMatcher::pop(FrameFate fate, const StampEstimate& released, std::optional<std::int64_t> pulse) {
  std::uint64_t MatchLedger::*const counters[] = {&MatchLedger::matched, &MatchLedger::doubled,
                                                  &MatchLedger::without_pulse, &MatchLedger::doubtful,
                                                  &MatchLedger::strays};
  ++(ledger_.*counters[static_cast<std::size_t>(fate)]);
  const FrameMatch match{waiting_.front().frame, fate, pulse, released.stamp_ns, released.error_ns};
  waiting_.erase(waiting_.begin());
  return match;
}

void FrameMatcher::settle_pulses() {
  const std::int64_t until = now_ns_ - options_.most_lag_ns - late_frame_ns - pulse_wait_ns;
  while (book_.size() > 0 && (is_finished_ || book_.pulse(0).stamp_ns < until)) settle_first_pulse();
}

void FrameMatcher::settle_first_pulse() {
  const TriggerPulse& pulse = book_.pulse(0);
  if (book_.is_taken(0)) {
    last_released_ns_ = pulse.stamp_ns;
    has_released_ = true;
  } else if (has_released_ && pulse.stamp_ns < last_released_ns_ + options_.least_interval_ns) {
    ++ledger_.pulses_too_soon;
  } else {
    ++ledger_.pulses_without_frame;
    if (ledger_.listed_pulses.size() < MatchLedger::kListed) ledger_.listed_pulses.push_back(pulse.pulse);
  }
  book_.drop_first();
}

std::optional<CameraClockFigures> FrameMatcher::clock() const {
  if (!line_) return std::nullopt;
  return CameraClockFigures{line_->drift_ppm(), line_->jitter_ns(), line_->at(last_stamp_).error_ns, line_->pairs()};
}

}  // namespace rigcal
