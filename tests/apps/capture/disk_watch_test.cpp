#include "apps/capture/disk_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::HasSubstr;

TEST(DiskForecast, TellsHowLongTheDiskLasts) {
  DiskForecast forecast;
  constexpr std::uint64_t free = 132ULL << 20U;
  EXPECT_FALSE(forecast.add(0.0, {}, free).seconds_left.has_value());
  const DiskRoom room = forecast.add(1.0, {10ULL << 20U, 0}, free);
  EXPECT_NEAR(room.bytes_per_s, 10.0 * 1048576.0, 1.0);
  EXPECT_NEAR(*room.seconds_left, 10.0, 1e-6);  // What is kept free does not count.
  // A rate that ends is forgotten slowly; one that goes on is kept.
  EXPECT_NEAR(forecast.add(2.0, {20ULL << 20U, 0}, free).bytes_per_s, 10.0 * 1048576.0, 1.0);
  EXPECT_NEAR(forecast.add(3.0, {20ULL << 20U, 0}, free).bytes_per_s, 9.0 * 1048576.0, 1.0);
  EXPECT_EQ(*forecast.add(4.0, {30ULL << 20U, 0}, DiskForecast::kReserveBytes / 2).seconds_left, 0.0);
  // --keep throws away: that is no growth, and nothing below zero.
  DiskForecast keeping;
  static_cast<void>(keeping.add(0.0, {100, 0}, free));
  EXPECT_EQ(keeping.add(1.0, {50, 0}, free).bytes_per_s, 0.0);
}

TEST(DiskForecast, PacketsGrowOnlyToWhatIsKept) {
  constexpr std::uint64_t mebibyte = 1ULL << 20U;
  constexpr std::uint64_t keep = 100 * mebibyte;
  const auto free = [](std::uint64_t room) { return DiskForecast::kReserveBytes + room * mebibyte; };
  // 8 MiB/s of packets into room for 20 MiB: full, unless no more than 20 MiB are to come.
  const auto left_s = [&free](std::uint64_t kept, std::uint64_t images_per_s, std::uint64_t room) {
    DiskForecast forecast(keep);
    static_cast<void>(forecast.add(0.0, {(kept - 8) * mebibyte, 0}, free(room)));
    return forecast.add(1.0, {kept * mebibyte, images_per_s * mebibyte}, free(room)).seconds_left;
  };
  EXPECT_NEAR(*left_s(50, 0, 20), 2.5, 1e-9);
  EXPECT_FALSE(left_s(80, 0, 21).has_value());
  EXPECT_FALSE(left_s(100, 0, 1).has_value());
  // With images the rest of the room is theirs.
  EXPECT_NEAR(*left_s(50, 2, 20), 2.0, 1e-9);
  EXPECT_NEAR(*left_s(80, 2, 60), 20.0, 1e-9);
  EXPECT_NEAR(*left_s(100, 2, 20), 10.0, 1e-9);
}

TEST(DiskWatch, WarnsOnceAndEndsOnce) {
  constexpr std::uint64_t mebibyte = 1ULL << 20U;
  constexpr std::uint64_t reserve = DiskForecast::kReserveBytes;
  DiskWatch watch("session");
  EXPECT_FALSE(watch.look(0.0, {}, reserve + 1000 * mebibyte).has_value());
  EXPECT_FALSE(watch.look(1.0, {mebibyte, 0}, reserve + 999 * mebibyte).has_value());  // 1 MiB/s: nearly 1000 s.
  const auto warning = watch.look(2.0, {2 * mebibyte, 0}, reserve + 100 * mebibyte);
  ASSERT_TRUE(warning.has_value());
  EXPECT_THAT(*warning, HasSubstr("full in about 100 s"));
  EXPECT_FALSE(watch.look(3.0, {3 * mebibyte, 0}, reserve + 99 * mebibyte).has_value());
  EXPECT_FALSE(watch.full().has_value());
  // The end: told by `full`, with what there was then; later looks change nothing.
  EXPECT_FALSE(watch.look(4.0, {4 * mebibyte, 0}, reserve - mebibyte).has_value());
  ASSERT_TRUE(watch.full().has_value());
  EXPECT_THAT(watch.full()->message(), HasSubstr("31 MiB"));
  EXPECT_THAT(watch.full()->message(), HasSubstr("session"));
  static_cast<void>(watch.look(5.0, {5 * mebibyte, 0}, reserve + 1000 * mebibyte));
  EXPECT_THAT(watch.full()->message(), HasSubstr("31 MiB"));
  EXPECT_EQ(watch.room()->free_bytes, reserve - mebibyte);
}

TEST(DiskWatch, DoesNotWarnOfWhatIsThrownAwayAgain) {
  constexpr std::uint64_t mebibyte = 1ULL << 20U;
  DiskWatch watch("session", 50 * mebibyte);
  std::uint64_t kept = 0;
  for (int i = 0; i < 100; ++i) {
    kept = kept + 7 > 50 ? 44 : kept + 7;
    const std::uint64_t free = DiskForecast::kReserveBytes + (60 - kept) * mebibyte;
    EXPECT_FALSE(watch.look(i, {kept * mebibyte, 0}, free).has_value()) << i;
  }
  EXPECT_FALSE(watch.full().has_value());
}

}  // namespace
}  // namespace rigcal
