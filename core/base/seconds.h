#pragma once

#include <chrono>

namespace rigcal {

using SteadyClock = std::chrono::steady_clock;

[[nodiscard]] inline double seconds_between(SteadyClock::time_point from, SteadyClock::time_point to) {
  return std::chrono::duration<double>(to - from).count();
}
[[nodiscard]] inline double seconds_since(SteadyClock::time_point from) {
  return seconds_between(from, SteadyClock::now());
}

}  // namespace rigcal
