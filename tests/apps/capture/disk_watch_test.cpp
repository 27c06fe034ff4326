#include "apps/capture/disk_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::HasSubstr;

TEST(DiskForecast, TellsHowLongTheDiskLasts) {
  DiskForecast forecast;
  constexpr std::uint64_t free = 132ULL << 20U;
  EXPECT_FALSE(forecast.add(0.0, 0, free).seconds_left.has_value());
  const DiskRoom room = forecast.add(1.0, 10ULL << 20U, free);
  EXPECT_NEAR(room.bytes_per_s, 10.0 * 1048576.0, 1.0);
  EXPECT_NEAR(*room.seconds_left, 10.0, 1e-6);  // What is kept free does not count.
  // A rate that ends is forgotten slowly; one that goes on is kept.
  EXPECT_NEAR(forecast.add(2.0, 20ULL << 20U, free).bytes_per_s, 10.0 * 1048576.0, 1.0);
  EXPECT_NEAR(forecast.add(3.0, 20ULL << 20U, free).bytes_per_s, 9.0 * 1048576.0, 1.0);
  EXPECT_EQ(*forecast.add(4.0, 30ULL << 20U, DiskForecast::kReserveBytes / 2).seconds_left, 0.0);
  // --keep throws away: that is no growth, and nothing below zero.
  DiskForecast keeping;
  static_cast<void>(keeping.add(0.0, 100, free));
  EXPECT_EQ(keeping.add(1.0, 50, free).bytes_per_s, 0.0);
}

TEST(DiskWatch, WarnsOnceAndEndsOnce) {
  constexpr std::uint64_t mebibyte = 1ULL << 20U;
  constexpr std::uint64_t reserve = DiskForecast::kReserveBytes;
  DiskWatch watch("session");
  EXPECT_FALSE(watch.look(0.0, 0, reserve + 1000 * mebibyte).has_value());
  EXPECT_FALSE(watch.look(1.0, mebibyte, reserve + 999 * mebibyte).has_value());  // 1 MiB/s: nearly 1000 s.
  const auto warning = watch.look(2.0, 2 * mebibyte, reserve + 100 * mebibyte);
  ASSERT_TRUE(warning.has_value());
  EXPECT_THAT(*warning, HasSubstr("full in about 100 s"));
  EXPECT_FALSE(watch.look(3.0, 3 * mebibyte, reserve + 99 * mebibyte).has_value());
  EXPECT_FALSE(watch.full().has_value());
  // The end: told by `full`, with what there was then; later looks change nothing.
  EXPECT_FALSE(watch.look(4.0, 4 * mebibyte, reserve - mebibyte).has_value());
  ASSERT_TRUE(watch.full().has_value());
  EXPECT_THAT(watch.full()->message(), HasSubstr("31 MiB"));
  EXPECT_THAT(watch.full()->message(), HasSubstr("session"));
  static_cast<void>(watch.look(5.0, 5 * mebibyte, reserve + 1000 * mebibyte));
  EXPECT_THAT(watch.full()->message(), HasSubstr("31 MiB"));
  EXPECT_EQ(watch.room()->free_bytes, reserve - mebibyte);
}

}  // namespace
}  // namespace rigcal
