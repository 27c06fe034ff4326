#include "core/clocks/onward_time.h"

#include <gtest/gtest.h>

#include <limits>

namespace rigcal {
namespace {

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t s = 1'000 * ms;
constexpr std::int64_t start_ns = 1'700'000'000 * s;

/// A recording of a packet each millisecond: what its machine says, and what is made of it.
class Recording {
 public:
  std::int64_t next(std::int64_t clock_off_ns = 0) {
    const std::int64_t stamp_ns = now_ns() + clock_off_ns;
    return time.add(stamp_ns, number_++);
  }
  void run(int packets, std::int64_t clock_off_ns = 0) {
    for (int i = 0; i < packets; ++i) static_cast<void>(next(clock_off_ns));
  }
  [[nodiscard]] std::int64_t now_ns() const { return start_ns + static_cast<std::int64_t>(number_) * ms; }

  OnwardTime time;

 private:
  std::uint64_t number_ = 0;
};

TEST(OnwardTime, LeavesStampsAsTheyAreWhereTheClockIsNotSetBack) {
  Recording recording;
  for (const std::int64_t off : {0 * ms, -20 * ms, -900 * ms, 0 * ms, 5 * s, 5 * s, 4 * s}) {
    for (int i = 0; i < 20; ++i) {
      const std::int64_t stamp = recording.now_ns() + off;
      EXPECT_EQ(recording.next(off), stamp);
    }
  }
  EXPECT_EQ(recording.time.steps(), 0);
}

TEST(OnwardTime, GoesOnWhereTheClockIsSetBack) {
  Recording recording;
  recording.run(100);
  recording.run(4, -3600 * s);
  for (int i = 0; i < 3000; ++i) {
    const std::int64_t now = recording.now_ns();
    ASSERT_NEAR(static_cast<double>(recording.next(-3600 * s) - now), 0.0, 1.0 * ms) << i;
  }
  EXPECT_EQ(recording.time.steps(), 1);
  EXPECT_EQ(recording.time.first_step_place(), 100U);
  EXPECT_NEAR(1e-9 * static_cast<double>(recording.time.first_step_ns()), 3600.0, 0.01);
  // Set back once more, later set right: back where it was.
  recording.run(4, -3700 * s);
  for (int i = 0; i < 100; ++i) {
    const std::int64_t now = recording.now_ns();
    ASSERT_NEAR(static_cast<double>(recording.next(-3700 * s) - now), 0.0, 2.0 * ms) << i;
  }
  const std::int64_t now = recording.now_ns();
  EXPECT_NEAR(static_cast<double>(recording.next(-3600 * s) - now), 0.0, 2.0 * ms);
  EXPECT_EQ(recording.time.steps(), 2);
  EXPECT_EQ(recording.time.first_step_place(), 100U);
}

TEST(OnwardTime, DoesNotFollowSingleStamps) {
  Recording recording;
  EXPECT_EQ(recording.next(500'000 * s), start_ns + 500'000 * s) << "nor the first";
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t off = i % 17 == 8 ? -100 * s : i % 17 == 12 ? 1'000'000 * s : 0;
    const std::int64_t stamp = recording.now_ns() + off;
    ASSERT_EQ(recording.next(off), stamp);
  }
  EXPECT_EQ(recording.time.steps(), 0);
}

TEST(OnwardTime, IsNotRunAwayWithByTwoClocks) {
  Recording recording;
  recording.run(50);
  for (int i = 0; i < 100; ++i) {
    for (int k = 0; k < 10; ++k) {
      const std::int64_t now = recording.now_ns();
      const std::int64_t time = recording.next(-50 * s);
      if (i > 0 || k >= 4) {
        ASSERT_NEAR(static_cast<double>(time - now), 0.0, 2.0 * ms) << i;
      }
    }
    const std::int64_t now = recording.now_ns();
    ASSERT_EQ(recording.next(), now);
  }
  EXPECT_EQ(recording.time.steps(), 1);
}

TEST(OnwardTime, GoesOnAfterASilence) {
  Recording recording;
  recording.run(10);
  recording.run(10, 60 * s);
  recording.run(4, -3600 * s);
  const std::int64_t now = recording.now_ns();
  EXPECT_NEAR(static_cast<double>(recording.next(-3600 * s) - now), 60e9, 1.0 * ms) << "from where the time was";
}

TEST(OnwardTime, SurvivesAnyValues) {
  using Limits = std::numeric_limits<std::int64_t>;
  OnwardTime time;
  for (int i = 0; i < 1000; ++i) {
    const std::int64_t stamp = i % 30 < 10 ? Limits::max() : i % 30 < 20 ? Limits::min() : 0;
    static_cast<void>(time.add(stamp - (i % 3 == 0 && stamp > 0 ? 1 : 0), 0));
  }
  EXPECT_GE(time.steps(), 0);
}

}  // namespace
}  // namespace rigcal
