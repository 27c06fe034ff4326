#include "drivers/trigger/pulse_machine.h"

#include <algorithm>
#include <limits>
#include <string>

namespace rigcal::trigger {
namespace {

constexpr std::int64_t least_width_ns = 1'000;
constexpr std::int64_t longest_ns = 3'600'000'000'000;

std::string microseconds(std::int64_t time_ns) { return std::to_string(time_ns / 1000) + " us"; }

}  // namespace

Expected<void> check_pattern(const PulsePattern& pattern) {
  if (pattern.width_ns < least_width_ns)
    return input_error("a trigger pulse of less than 1 us", "trigger", "make pulse_us at least 1");
  if (pattern.period_ns > longest_ns || pattern.burst_period_ns > longest_ns)
    return input_error("trigger pulses more than an hour apart", "trigger", "make them come more often");
  if (pattern.period_ns <= pattern.width_ns)
    return input_error("trigger pulses of " + microseconds(pattern.width_ns) + " every " +
                           microseconds(pattern.period_ns) + " leave no time between them",
                       "trigger", "make them shorter (pulse_us) or come less often");
  if (pattern.burst > 0 && pattern.burst_period_ns / pattern.burst < pattern.period_ns)
    return input_error("bursts of " + std::to_string(pattern.burst) + " pulses every " +
                           microseconds(pattern.period_ns) + " do not fit into " +
                           microseconds(pattern.burst_period_ns),
                       "trigger", "take fewer pulses, or let the bursts come less often");
  return {};
}

PulseMachine::PulseMachine(const PulsePattern& pattern, std::int64_t start_ns)
    : pattern_(pattern), start_ns_(start_ns), rises_from_ns_(std::numeric_limits<std::int64_t>::min()) {
  RIGCAL_ASSERT(check_pattern(pattern).has_value(), "a pulse pattern that was not checked");
}

std::int64_t PulseMachine::due_ns(std::uint64_t place) const {
  if (pattern_.burst == 0) return start_ns_ + static_cast<std::int64_t>(place) * pattern_.period_ns;
  return start_ns_ + static_cast<std::int64_t>(place / pattern_.burst) * pattern_.burst_period_ns +
         static_cast<std::int64_t>(place % pattern_.burst) * pattern_.period_ns;
}

bool PulseMachine::is_over() const { return is_ended_ || (pattern_.count > 0 && pulses_ >= pattern_.count); }

std::optional<PulseAction> PulseMachine::step(std::int64_t now_ns) {
  if (is_high_) {
    if (now_ns < falls_ns_) return std::nullopt;
    is_high_ = false;
    rises_from_ns_ = now_ns + std::min(pattern_.width_ns, (pattern_.period_ns - pattern_.width_ns) / 2);
    return PulseAction{false, pulses_ - 1, falls_ns_};
  }
  for (; is_held_ && !is_over() && due_ns(place_) <= now_ns; ++place_) ++held_;
  if (is_held_) return std::nullopt;
  while (!is_over() && due_ns(place_) + pattern_.period_ns / 2 < now_ns) ++place_;
  if (is_over()) return std::nullopt;
  const std::int64_t due = due_ns(place_);
  if (now_ns < std::max(due, rises_from_ns_)) return std::nullopt;
  is_high_ = true;
  falls_ns_ = now_ns + pattern_.width_ns;
  ++place_;
  return PulseAction{true, pulses_++, due};
}

std::optional<std::int64_t> PulseMachine::wake_ns() const {
  if (is_high_) return falls_ns_;
  if (is_over()) return std::nullopt;
  return std::max(due_ns(place_), rises_from_ns_);
}

}  // namespace rigcal::trigger
