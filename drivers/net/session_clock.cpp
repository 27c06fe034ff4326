#include "drivers/net/session_clock.h"

#include <ctime>

#include "core/base/seconds.h"

namespace rigcal::net {
namespace {

std::int64_t read(clockid_t clock) {
  timespec time{};
  clock_gettime(clock, &time);
  return static_cast<std::int64_t>(time.tv_sec) * ns_per_second + time.tv_nsec;
}

}  // namespace

ClockReading read_clocks() {
  // The middle of two readings: a pause between them would otherwise be an error of one side. The closest of three
  // tries is taken.
  ClockReading best;
  std::int64_t shortest = INT64_MAX;
  for (int i = 0; i < 3; ++i) {
    const std::int64_t before = read(CLOCK_MONOTONIC);
    const std::int64_t realtime = read(CLOCK_REALTIME);
    const std::int64_t took = read(CLOCK_MONOTONIC) - before;
    if (took >= shortest) continue;
    shortest = took;
    best = {realtime, before + took / 2};
  }
  return best;
}

}  // namespace rigcal::net
