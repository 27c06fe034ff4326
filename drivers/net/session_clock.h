#pragma once

#include <cstdint>

namespace rigcal::net {

/// CLOCK_REALTIME and CLOCK_MONOTONIC read together.
struct ClockReading {
  std::int64_t realtime_ns = 0;
  std::int64_t monotonic_ns = 0;
};
[[nodiscard]] ClockReading read_clocks();

/// What came within the last seconds came within so many.
constexpr std::int64_t kRecentNs = 10'000'000'000;

/// CLOCK_MONOTONIC of a stamp by CLOCK_REALTIME of which it is known that it was taken within the last seconds before
/// `now`: one from the other side of a step of CLOCK_REALTIME, as far as that shows, is `now`.
[[nodiscard]] std::int64_t monotonic_of_recent(std::int64_t realtime_ns, const ClockReading& now);

/// The session clock: CLOCK_MONOTONIC plus one offset, fixed when it is made, so that it reads as UTC and never steps.
/// Kernel stamps are CLOCK_REALTIME, which may be set at any time: they are mapped by the latest pair of readings.
class SessionClock {
 public:
  explicit SessionClock(const ClockReading& start) : start_(start), latest_(start) {}

  /// A pair to map the stamps that follow; to be given about every 100 ms.
  void update(const ClockReading& reading) { latest_ = reading; }
  [[nodiscard]] std::int64_t from_realtime(std::int64_t stamp_ns) const {
    return from_monotonic(stamp_ns - latest_.realtime_ns + latest_.monotonic_ns);
  }
  /// The same for a stamp of which it is known that it was taken within the last seconds before `now`: one from the
  /// other side of a step of CLOCK_REALTIME, which no pair maps, is `now`.
  [[nodiscard]] std::int64_t from_recent_realtime(std::int64_t stamp_ns, const ClockReading& now) const {
    const std::int64_t mapped_ns = from_realtime(stamp_ns);
    const std::int64_t now_ns = from_monotonic(now.monotonic_ns);
    return mapped_ns > now_ns - kRecentNs && mapped_ns < now_ns + kRecentNs ? mapped_ns : now_ns;
  }
  /// Whether CLOCK_REALTIME was set between the latest pair and this one.
  [[nodiscard]] bool has_stepped(const ClockReading& now) const {
    const std::int64_t step = (now.realtime_ns - latest_.realtime_ns) - (now.monotonic_ns - latest_.monotonic_ns);
    return step > kStepNs || step < -kStepNs;
  }
  [[nodiscard]] std::int64_t from_monotonic(std::int64_t stamp_ns) const {
    return stamp_ns - start_.monotonic_ns + start_.realtime_ns;
  }
  [[nodiscard]] const ClockReading& start() const { return start_; }
  [[nodiscard]] const ClockReading& latest() const { return latest_; }

 private:
  static constexpr std::int64_t kStepNs = 1'000'000;
  ClockReading start_;
  ClockReading latest_;
};

}  // namespace rigcal::net
