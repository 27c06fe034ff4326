#include "core/clocks/pulse_time.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr std::int64_t kSecond = 1'000'000'000;

TEST(PulseTime, CountsTheSecondsThroughJitterAndLoss) {
  Random random(1);
  PulseTime pulse;
  std::int64_t true_ns = 700'000'000;
  for (int i = 0; i < 20000; ++i) {
    const auto late = static_cast<std::int64_t>(random.uniform(0.0, 0.1) * 1e9);
    EXPECT_EQ(pulse.add(true_ns % kSecond, 50 * kSecond + true_ns + late), true_ns);
    true_ns += random.uniform() < 0.01 ? 7'300'000'000 : 960'000;  // Now and then seconds are missing.
  }
}

TEST(PulseTime, GoesOnWhereAPulseIsMissed) {
  PulseTime pulse;
  EXPECT_EQ(pulse.add(900'000'000, 0), 900'000'000);
  EXPECT_EQ(pulse.add(1'100'000'000, 200'000'000), 1'100'000'000);
  EXPECT_EQ(pulse.add(300'000'000, 1'400'000'000), 2'300'000'000);
}

TEST(PulseTime, TakesAPacketOutOfOrderAcrossThePulse) {
  PulseTime pulse;
  EXPECT_EQ(pulse.add(999'000'000, 0), 999'000'000);
  EXPECT_EQ(pulse.add(1'000'000, 2'000'000), 1'001'000'000);
  EXPECT_EQ(pulse.add(999'500'000, 2'100'000), 999'500'000);
}

TEST(PulseTime, IsRightAgainAfterWildStamps) {
  PulseTime pulse;
  std::int64_t true_ns = 300'000'000;
  EXPECT_EQ(pulse.add(true_ns, 50 * kSecond + true_ns), true_ns);
  for (const std::int64_t wild_ns : {INT64_MAX, INT64_MIN, std::int64_t{0}, -kSecond}) {
    for (const std::int64_t received_ns : {INT64_MAX, INT64_MIN, std::int64_t{0}, std::int64_t{1} << 61U}) {
      (void)pulse.add(wild_ns, received_ns);
      true_ns += 1'250'000'000;
      EXPECT_EQ(pulse.add(true_ns % kSecond, 50 * kSecond + true_ns), true_ns) << wild_ns << " " << received_ns;
    }
  }
}

TEST(PulseTime, CountsThoughTheFirstStampsWereWild) {
  for (const std::int64_t wild_ns : {INT64_MAX, INT64_MIN}) {
    PulseTime pulse;
    (void)pulse.add(0, wild_ns);
    for (std::int64_t true_ns = 300'000'000; true_ns < 10 * kSecond; true_ns += 400'000'000)
      EXPECT_EQ(pulse.add(true_ns % kSecond, 50 * kSecond + true_ns), true_ns) << wild_ns;
  }
  PulseTime pulse;
  (void)pulse.add(0, INT64_MAX);
  (void)pulse.add(0, INT64_MIN);
  (void)pulse.add(0, INT64_MAX);
  EXPECT_EQ(pulse.add(300'000'000, 50 * kSecond), 300'000'000);
  EXPECT_EQ(pulse.add(300'000'000, 51 * kSecond), 1'300'000'000);
}

}  // namespace
}  // namespace rigcal
