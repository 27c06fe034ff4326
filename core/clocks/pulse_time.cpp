#include "core/clocks/pulse_time.h"

#include <cmath>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr std::int64_t most_seconds = std::int64_t{1} << 32U;  // Keeps hostile stamps from overflowing.

}  // namespace

// Nothing where the two were received too far apart.
std::optional<std::int64_t> PulseTime::following(const Stamp& last, std::int64_t since_pulse_ns,
                                                 std::int64_t received_ns) {
  const double elapsed = static_cast<double>(received_ns) - static_cast<double>(last.received_ns);
  const double seconds = (static_cast<double>(last.ns - since_pulse_ns) + elapsed) / static_cast<double>(ns_per_second);
  const double whole = std::nearbyint(seconds);
  if (!(std::abs(whole) < static_cast<double>(most_seconds))) return std::nullopt;
  return since_pulse_ns + static_cast<std::int64_t>(whole) * ns_per_second;
}

std::int64_t PulseTime::add(std::int64_t since_pulse_ns, std::int64_t received_ns) {
  const std::int64_t in_second = since_pulse_ns % (most_seconds * 2);
  for (const std::optional<Stamp>* before : {&last_, &doubtful_}) {
    if (!*before) continue;
    if (const std::optional<std::int64_t> ns = following(**before, in_second, received_ns)) {
      last_ = Stamp{*ns, received_ns};
      doubtful_.reset();
      return *ns;
    }
  }
  (last_ ? doubtful_ : last_) = Stamp{in_second, received_ns};
  return in_second;
}

}  // namespace rigcal
