#pragma once

#include <chrono>

namespace rigcal::targetless {

using Clock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_between(Clock::time_point from, Clock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}
[[nodiscard]] inline double seconds_since(Clock::time_point from) { return seconds_between(from, Clock::now()); }

}  // namespace rigcal::targetless
