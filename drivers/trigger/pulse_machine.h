#pragma once

#include <cstdint>
#include <optional>

#include "core/base/error.h"

namespace rigcal::trigger {

/// How pulses follow each other.
struct PulsePattern {
  std::int64_t period_ns = 50'000'000;
  std::int64_t width_ns = 1'000'000;
  std::uint64_t count = 0;           ///< Pulses to be given, those left out do not count; 0: until it is stopped.
  std::uint32_t burst = 0;           ///< Pulses of a burst; 0: no bursts, all are a period apart.
  std::int64_t burst_period_ns = 0;  ///< From the start of a burst to that of the next one.
};

/// Errors (kind input): a width that leaves no time between pulses, times out of range, bursts that overlap.
[[nodiscard]] Expected<void> check_pattern(const PulsePattern& pattern);

/// What a line has to do.
struct PulseAction {
  bool is_high = false;     ///< The level to set; high begins a pulse.
  std::uint64_t pulse = 0;  ///< Number of the pulse that begins or ends, from 0.
  std::int64_t due_ns = 0;  ///< When it was due.
};

/// When a trigger line is high: a pure state machine, times of any monotonic clock.
///
///   low  --(the next place in the pattern has come, and the line was low long enough)-->  high
///   high --(a width after the pulse really began)-->  low
///
/// Late pulses keep their width, and pulses are never squeezed together: what could only begin more than half a period
/// late is left out and counted, as after a pause of the whole machine.
class PulseMachine {
 public:
  /// A pattern that `check_pattern` takes.
  PulseMachine(const PulsePattern& pattern, std::int64_t start_ns);

  /// What is to be done now; nothing where it is too early or all is done. To be called until it gives nothing.
  [[nodiscard]] std::optional<PulseAction> step(std::int64_t now_ns);
  /// While it is held no pulse begins, and places of the pattern pass by; one that is under way ends in its time.
  void hold(bool is_held) { is_held_ = is_held; }
  /// No pulse begins any more; one that is under way ends in its time.
  void end() { is_ended_ = true; }
  /// When `step` has something to do; nothing: never again.
  [[nodiscard]] std::optional<std::int64_t> wake_ns() const;

  [[nodiscard]] std::uint64_t pulses() const { return pulses_; }
  [[nodiscard]] std::uint64_t held() const { return held_; }  ///< Places that passed by meanwhile.
  [[nodiscard]] std::uint64_t skipped() const { return place_ - pulses_ - held_; }

 private:
  [[nodiscard]] std::int64_t due_ns(std::uint64_t place) const;
  [[nodiscard]] bool is_over() const;

  PulsePattern pattern_;
  std::int64_t start_ns_ = 0;
  std::uint64_t place_ = 0;  ///< The next one in the pattern.
  std::uint64_t pulses_ = 0;
  std::uint64_t held_ = 0;
  bool is_held_ = false;
  bool is_high_ = false;
  bool is_ended_ = false;
  std::int64_t falls_ns_ = 0;
  std::int64_t rises_from_ns_ = 0;
};

}  // namespace rigcal::trigger
