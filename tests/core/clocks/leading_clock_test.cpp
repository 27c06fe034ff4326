#include "core/clocks/leading_clock.h"

#include <gtest/gtest.h>

#include <limits>

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1'000 * ms;
constexpr std::int64_t frame_ns = 50 * ms;

TEST(LeadingClock, IsTheClockOfTheDeviceThatSpeaksFirst) {
  LeadingClock clock(frame_ns);
  EXPECT_EQ(clock.add(3, 7 * s, false, 0), 7 * s);
  EXPECT_EQ(clock.add(1, 900 * s, false, 0), 7 * s);
  EXPECT_EQ(clock.add(3, 7 * s + 1, false, 0), 7 * s + 1);
  EXPECT_EQ(clock.add(1, 0, false, 1), 7 * s + 1);
  EXPECT_EQ(clock.add(3, 7 * s + 60 * ms, false, 1), 7 * s + 60 * ms);
  EXPECT_EQ(clock.now_ns(), 7 * s + 60 * ms);
}

TEST(LeadingClock, DoesNotGoBackForPacketsThatOvertookEachOther) {
  LeadingClock clock(frame_ns);
  EXPECT_EQ(clock.add(0, 10 * ms, false, 0), 10 * ms);
  EXPECT_EQ(clock.add(0, 9 * ms, false, 1), 10 * ms);
  EXPECT_EQ(clock.add(0, 12 * ms, false, 1), 12 * ms);
}

TEST(LeadingClock, CountsPulsesOn) {
  LeadingClock clock(frame_ns);
  EXPECT_EQ(clock.add(0, 990 * ms, true, 0), 990 * ms);
  EXPECT_EQ(clock.add(0, 10 * ms, true, 1), 1010 * ms);
  EXPECT_EQ(clock.add(0, 20 * ms, true, 1 + 2 * 20), 3020 * ms);  // two seconds are missing
}

TEST(LeadingClock, CarriesTheTimeOverWhereTheLeaderStartsAgainOrIsSet) {
  LeadingClock clock(frame_ns);
  EXPECT_EQ(clock.add(0, 100 * s, false, 0), 100 * s);
  EXPECT_EQ(clock.add(0, 1 * s, false, 4), 100 * s + 4 * frame_ns);
  EXPECT_EQ(clock.add(0, 1 * s + 7, false, 4), 100 * s + 4 * frame_ns + 7);
  EXPECT_EQ(clock.add(0, 5'000 * s, false, 5), 100 * s + 5 * frame_ns + 7);
  EXPECT_EQ(clock.add(0, 5'010 * s, false, 205), 110 * s + 5 * frame_ns + 7);  // a gap that the frames have too
}

TEST(LeadingClock, HandsTheLeadOnWhenTheLeaderFallsSilent) {
  LeadingClock clock(frame_ns);
  EXPECT_EQ(clock.add(0, 1 * s, false, 0), 1 * s);
  EXPECT_EQ(clock.add(1, 50 * s, false, 3), 1 * s);
  EXPECT_EQ(clock.add(1, 50 * s + 50 * ms, false, 4), 1 * s + 4 * frame_ns);
  EXPECT_EQ(clock.add(1, 50 * s + 60 * ms, false, 4), 1 * s + 4 * frame_ns + 10 * ms);
  EXPECT_EQ(clock.add(0, 2 * s, false, 4), 1 * s + 4 * frame_ns + 10 * ms);  // back, but no longer in the lead
}

TEST(LeadingClock, SurvivesAnyValues) {
  LeadingClock clock(10 * s);
  std::int64_t before = 0;
  for (const std::int64_t stamp : {std::numeric_limits<std::int64_t>::max(), std::numeric_limits<std::int64_t>::min(),
                                   std::int64_t{0}, std::int64_t{5}, std::numeric_limits<std::int64_t>::max()}) {
    for (const std::uint64_t frame : {std::uint64_t{0}, std::numeric_limits<std::uint64_t>::max()}) {
      const std::int64_t now = clock.add(static_cast<int>(frame % 2), stamp, frame == 0, frame);
      EXPECT_GE(now, before);
      before = now;
    }
  }
}

}  // namespace
}  // namespace rigcal
