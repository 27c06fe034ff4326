#include "drivers/net/session_clock.h"

#include <gtest/gtest.h>

namespace rigcal::net {
namespace {

constexpr std::int64_t second = 1'000'000'000;

TEST(SessionClock, ReadsAsUtcAndDoesNotStepWithIt) {
  SessionClock clock({1'700'000'000 * second, 50 * second});
  EXPECT_EQ(clock.from_realtime(1'700'000'001 * second), 1'700'000'001 * second);
  EXPECT_EQ(clock.from_monotonic(51 * second), 1'700'000'001 * second);
  // The wall clock is set back by an hour: the session goes on.
  clock.update({(1'700'000'002 - 3600) * second, 52 * second});
  EXPECT_EQ(clock.from_realtime((1'700'000'003 - 3600) * second), 1'700'000'003 * second);
  EXPECT_EQ(clock.from_monotonic(53 * second), 1'700'000'003 * second);
}

TEST(SessionClock, ReadsBothClocksAtOnce) {
  const ClockReading first = read_clocks();
  const ClockReading second_reading = read_clocks();
  EXPECT_GE(second_reading.monotonic_ns, first.monotonic_ns);
  const std::int64_t between =
      (second_reading.realtime_ns - first.realtime_ns) - (second_reading.monotonic_ns - first.monotonic_ns);
  EXPECT_LT(std::abs(between), 10'000'000);
}

}  // namespace
}  // namespace rigcal::net
