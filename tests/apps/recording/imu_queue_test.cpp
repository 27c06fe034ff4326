#include "apps/recording/imu_queue.h"

#include <gtest/gtest.h>

#include <vector>

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;

struct Given {
  std::vector<std::int64_t> stamps_ms;
  ImuQueue queue{[this](const ImuSample& sample) { stamps_ms.push_back(sample.stamp_ns / ms); }};

  void add(std::int64_t stamp_ms) { queue.add({.sensor = 0, .stamp_ns = stamp_ms * ms}, stamp_ms * ms); }
};

TEST(ImuQueue, ReadingsWaitForTheCloudsOfAllLidars) {
  Given given;
  given.queue.wait_for(0);
  given.queue.wait_for(1);
  for (const std::int64_t stamp_ms : {0, 500, 1000, 1500}) given.add(stamp_ms);
  given.queue.seen(0, 1400 * ms);
  given.queue.hand_on(1500 * ms);
  EXPECT_TRUE(given.stamps_ms.empty());
  given.queue.seen(1, 1000 * ms);
  given.queue.hand_on(1500 * ms);
  EXPECT_EQ(given.stamps_ms, (std::vector<std::int64_t>{0, 500, 1000}));
  given.queue.flush();
  EXPECT_EQ(given.stamps_ms.size(), 4U);
}

TEST(ImuQueue, ASilentLidarIsNotWaitedForForever) {
  Given given;
  given.queue.wait_for(0);
  for (std::int64_t stamp_ms = 0; stamp_ms <= 10'000; stamp_ms += 100) {
    given.add(stamp_ms);
    given.queue.hand_on(stamp_ms * ms);
  }
  EXPECT_EQ(given.stamps_ms.back(), 7400);
}

TEST(ImuQueue, WithoutLidarsNothingWaits) {
  Given given;
  given.add(5);
  given.queue.hand_on(5 * ms);
  EXPECT_EQ(given.stamps_ms.size(), 1U);
}

}  // namespace
}  // namespace rigcal
