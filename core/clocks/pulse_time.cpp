#include "core/clocks/pulse_time.h"

#include <cmath>

#include "core/base/seconds.h"

namespace rigcal {

std::int64_t PulseTime::add(std::int64_t since_pulse_ns, std::int64_t received_ns) {
  constexpr std::int64_t most_seconds = std::int64_t{1} << 32U;  // Keeps hostile stamps from overflowing.
  if (!started_) {
    started_ = true;
    last_ns_ = since_pulse_ns % (most_seconds * 2);
    last_received_ns_ = received_ns;
    return last_ns_;
  }
  const std::int64_t in_second = since_pulse_ns % (most_seconds * 2);
  const double elapsed = static_cast<double>(received_ns) - static_cast<double>(last_received_ns_);
  const double seconds = (static_cast<double>(last_ns_ - in_second) + elapsed) / static_cast<double>(ns_per_second);
  const double whole = std::nearbyint(seconds);
  const double limit = static_cast<double>(most_seconds);
  if (!(std::abs(whole) < limit)) return in_second;
  last_ns_ = in_second + static_cast<std::int64_t>(whole) * ns_per_second;
  last_received_ns_ = received_ns;
  return last_ns_;
}

}  // namespace rigcal
