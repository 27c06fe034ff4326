#pragma once

#include <chrono>
#include <cmath>
#include <cstdint>

namespace rigcal {

inline constexpr std::int64_t ns_per_second = 1'000'000'000;

[[nodiscard]] inline double seconds_of_ns(std::int64_t ns) { return 1e-9 * static_cast<double>(ns); }
/// Rounded to the nearest.
[[nodiscard]] inline std::int64_t ns_of_seconds(double seconds) { return std::llround(seconds * 1e9); }
/// What is less than a nanosecond is cut off.
[[nodiscard]] constexpr std::int64_t whole_ns_of_seconds(double seconds) {
  return static_cast<std::int64_t>(seconds * 1e9);
}

/// CLOCK_MONOTONIC on Linux, by which the kernel stamps, too.
using SteadyClock = std::chrono::steady_clock;

[[nodiscard]] inline std::int64_t monotonic_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(SteadyClock::now().time_since_epoch()).count();
}
[[nodiscard]] inline double seconds_between(SteadyClock::time_point from, SteadyClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}
[[nodiscard]] inline double seconds_since(SteadyClock::time_point from) {
  return seconds_between(from, SteadyClock::now());
}

}  // namespace rigcal
