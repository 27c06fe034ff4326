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

TEST(SessionClock, StampsOnTheOtherSideOfAStepAreNotAnHourOff) {
  constexpr std::int64_t hour = 3600 * second;
  const ClockReading start{1'700'000'000 * second, 50 * second};
  SessionClock clock(start);
  // Set forth by an hour after the last pair, and not yet known of: what the kernel stamps now seems an hour early.
  const ClockReading set{start.realtime_ns + second + hour, start.monotonic_ns + second};
  EXPECT_TRUE(clock.has_stepped(set));
  EXPECT_EQ(clock.from_recent_realtime(set.realtime_ns, set), 1'700'000'001 * second);
  clock.update(set);
  EXPECT_FALSE(clock.has_stepped({set.realtime_ns + second, set.monotonic_ns + second}));
  // What it stamped before is taken out of the socket after.
  EXPECT_EQ(clock.from_recent_realtime(start.realtime_ns + second - 1000, set), 1'700'000'001 * second - 1000);
  EXPECT_EQ(clock.from_recent_realtime(set.realtime_ns - 1000, set), 1'700'000'001 * second - 1000);
  // Back again.
  const ClockReading back{start.realtime_ns + 2 * second, start.monotonic_ns + 2 * second};
  EXPECT_TRUE(clock.has_stepped(back));
  EXPECT_EQ(clock.from_recent_realtime(back.realtime_ns, back), 1'700'000'002 * second);
  // Slewing is no step.
  EXPECT_FALSE(clock.has_stepped({set.realtime_ns + second + 500'000, set.monotonic_ns + second}));
}

TEST(SessionClock, AStepOfHalfASecondDoesNotMoveWhatWasStampedBeforeIt) {
  const ClockReading start{1'700'000'000 * second, 50 * second};
  for (const std::int64_t step_ns : {second / 2, -second / 2, second / 20, -second / 20}) {
    SessionClock clock(start);
    // Packets gather for 10 ms; in their midst the wall clock is set.
    const std::int64_t since_ns = start.monotonic_ns + second;
    const std::int64_t stamped_ns = start.realtime_ns + second + 3'000'000;
    const ClockReading now{start.realtime_ns + second + 10'000'000 + step_ns, since_ns + 10'000'000};
    ASSERT_TRUE(clock.has_stepped(now));
    clock.update(now);
    EXPECT_EQ(clock.from_recent_realtime(stamped_ns, now, since_ns), stamped_ns) << step_ns;
    EXPECT_EQ(clock.from_recent_realtime(stamped_ns + 3'000'000 + step_ns, now, since_ns), stamped_ns + 3'000'000);
  }
}

TEST(RealtimeMap, WhatWasJustStampedIsNeverInTheFutureNorLongAgo) {
  const ClockReading now{1'700'000'000 * second, 50 * second};
  const RealtimeMap map(now);
  const std::int64_t since_ns = 49 * second;
  EXPECT_EQ(map.recent_monotonic(now.realtime_ns - second / 10, now, since_ns), 50 * second - second / 10);
  EXPECT_EQ(map.recent_monotonic(now.realtime_ns, now, since_ns), 50 * second);
  // Set between the stamp and `now`, with no pair from before: by an hour back, by an hour forth, by a second back.
  EXPECT_EQ(map.recent_monotonic(now.realtime_ns + 3600 * second, now, since_ns), 50 * second);
  EXPECT_EQ(map.recent_monotonic(now.realtime_ns - 3600 * second, now, since_ns), 50 * second);
  EXPECT_EQ(map.recent_monotonic(now.realtime_ns + second, now, since_ns), 50 * second);
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
