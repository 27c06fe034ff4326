#include "core/base/seconds.h"

#include <gtest/gtest.h>

#include <ctime>

namespace rigcal {
namespace {

TEST(Seconds, RoundToTheNearestNanosecondOrAreCutOff) {
  EXPECT_EQ(ns_of_seconds(1.5), 1'500'000'000);
  EXPECT_EQ(ns_of_seconds(2.6e-9), 3);
  EXPECT_EQ(ns_of_seconds(-2.6e-9), -3);
  EXPECT_EQ(whole_ns_of_seconds(2.6e-9), 2);
  EXPECT_EQ(whole_ns_of_seconds(-2.6e-9), -2);
  EXPECT_EQ(seconds_of_ns(-2'500'000'000), -2.5);
}

TEST(Seconds, NowIsByTheClockThatTheKernelStampsBy) {
  timespec kernel{};
  const std::int64_t before = monotonic_now_ns();
  ASSERT_EQ(clock_gettime(CLOCK_MONOTONIC, &kernel), 0);
  const std::int64_t between = kernel.tv_sec * ns_per_second + kernel.tv_nsec;
  EXPECT_LE(before, between);
  EXPECT_LE(between, monotonic_now_ns());
}

}  // namespace
}  // namespace rigcal
