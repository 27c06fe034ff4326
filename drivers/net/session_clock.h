#pragma once

#include <cstdint>
#include <initializer_list>

namespace rigcal::net {

/// CLOCK_REALTIME and CLOCK_MONOTONIC read together.
struct ClockReading {
  std::int64_t realtime_ns = 0;
  std::int64_t monotonic_ns = 0;
};
[[nodiscard]] ClockReading read_clocks();

/// Stamps by CLOCK_REALTIME, which may be set at any time, on CLOCK_MONOTONIC: by pairs of readings of both.
class RealtimeMap {
 public:
  explicit RealtimeMap(const ClockReading& start) : latest_(start), before_step_(start) {}

  /// A pair to map the stamps that follow; to be given about every 100 ms, and when CLOCK_REALTIME was set.
  void update(const ClockReading& reading) {
    if (has_stepped(reading)) before_step_ = latest_;
    latest_ = reading;
  }
  /// Whether CLOCK_REALTIME was set between the latest pair and this one.
  [[nodiscard]] bool has_stepped(const ClockReading& now) const {
    const std::int64_t step = (now.realtime_ns - latest_.realtime_ns) - (now.monotonic_ns - latest_.monotonic_ns);
    return step > kStepNs || step < -kStepNs;
  }
  [[nodiscard]] const ClockReading& latest() const { return latest_; }

  [[nodiscard]] std::int64_t monotonic(std::int64_t stamp_ns) const { return by(latest_, stamp_ns); }
  /// The same for a stamp of which it is known that it was taken between `since_ns` (CLOCK_MONOTONIC) and `now`: one
  /// from before a step of CLOCK_REALTIME is mapped by the pair before it; what no pair brings there is `now`.
  [[nodiscard]] std::int64_t recent_monotonic(std::int64_t stamp_ns, const ClockReading& now,
                                              std::int64_t since_ns) const {
    for (const ClockReading& pair : {latest_, before_step_}) {
      const std::int64_t monotonic_ns = by(pair, stamp_ns);
      if (monotonic_ns > since_ns - kStepNs && monotonic_ns < now.monotonic_ns + kStepNs) return monotonic_ns;
    }
    return now.monotonic_ns;
  }

 private:
  static constexpr std::int64_t kStepNs = 1'000'000;
  [[nodiscard]] static std::int64_t by(const ClockReading& pair, std::int64_t stamp_ns) {
    return stamp_ns - pair.realtime_ns + pair.monotonic_ns;
  }
  ClockReading latest_;
  ClockReading before_step_;
};

/// The session clock: CLOCK_MONOTONIC plus one offset, fixed when it is made, so that it reads as UTC and never steps.
class SessionClock {
 public:
  explicit SessionClock(const ClockReading& start) : start_(start), map_(start) {}

  /// See RealtimeMap.
  void update(const ClockReading& reading) { map_.update(reading); }
  [[nodiscard]] bool has_stepped(const ClockReading& now) const { return map_.has_stepped(now); }
  [[nodiscard]] const ClockReading& latest() const { return map_.latest(); }

  [[nodiscard]] std::int64_t from_realtime(std::int64_t stamp_ns) const {
    return from_monotonic(map_.monotonic(stamp_ns));
  }
  /// For a stamp that was taken since `since_ns`, see RealtimeMap; or within the last ten seconds.
  [[nodiscard]] std::int64_t from_recent_realtime(std::int64_t stamp_ns, const ClockReading& now,
                                                  std::int64_t since_ns) const {
    return from_monotonic(map_.recent_monotonic(stamp_ns, now, since_ns));
  }
  [[nodiscard]] std::int64_t from_recent_realtime(std::int64_t stamp_ns, const ClockReading& now) const {
    return from_recent_realtime(stamp_ns, now, now.monotonic_ns - kRecentNs);
  }
  [[nodiscard]] std::int64_t from_monotonic(std::int64_t stamp_ns) const {
    return stamp_ns - start_.monotonic_ns + start_.realtime_ns;
  }
  [[nodiscard]] const ClockReading& start() const { return start_; }

 private:
  static constexpr std::int64_t kRecentNs = 10'000'000'000;
  ClockReading start_;
  RealtimeMap map_;
};

}  // namespace rigcal::net
