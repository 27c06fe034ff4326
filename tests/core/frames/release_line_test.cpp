#include "core/frames/release_line.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr std::int64_t second = 1'000'000'000;

/// A camera's clock that began at another time and runs fast.
std::int64_t device_time(std::int64_t session_ns, double drift_ppm) {
  return 77 * second + session_ns + std::llround(static_cast<double>(session_ns) * drift_ppm * 1e-6);
}

TEST(ReleaseLine, LearnsOffsetRateAndJitterAndKnowsItsError) {
  Random random(5);
  ReleaseLine line({}, device_time(0, 150.0), 0);
  int outside = 0;
  for (int i = 1; i <= 2000; ++i) {
    const std::int64_t pulse = i * (second / 20);
    const std::int64_t stamp = device_time(pulse, 150.0) + std::llround(random.normal() * 200e3);
    const StampEstimate estimate = line.at(stamp);
    if (std::abs(static_cast<double>(estimate.stamp_ns - pulse)) > 2.0 * estimate.error_ns) ++outside;
    line.add(stamp, pulse);
  }
  EXPECT_NEAR(line.drift_ppm(), 150.0, 2.0);
  EXPECT_NEAR(line.jitter_ns(), 200e3, 80e3);  // Learnt from about 32 stamps.
  EXPECT_LT(outside, 160);                     // 4.6 % are beyond two standard deviations.
  EXPECT_GT(outside, 40);
}

TEST(ReleaseLine, IsLessSureAfterAPause) {
  ReleaseLine line({}, 0, 0);
  for (std::int64_t i = 1; i <= 100; ++i) line.add(i * second / 20, i * second / 20);
  const double soon = line.at(5 * second + second / 20).error_ns;
  EXPECT_GT(line.at(60 * second).error_ns, 1.2 * soon);
  EXPECT_GT(line.at(600 * second).error_ns, 3.0 * soon);
  EXPECT_NEAR(static_cast<double>(line.at(600 * second).stamp_ns), 600e9, 10.0 * line.at(600 * second).error_ns);
}

TEST(ReleaseLine, IsNotMovedByOneBadStamp) {
  ReleaseLine line({}, 0, 0);
  for (std::int64_t i = 1; i <= 100; ++i) line.add(i * second / 20, i * second / 20);
  line.add(5 * second + second / 20, 5 * second + second / 20 + 1'000'000);
  EXPECT_NEAR(static_cast<double>(line.at(6 * second).stamp_ns - 6 * second), 0.0, 30e3);
}

TEST(ReleaseLine, TakesAnyStamp) {
  ReleaseLine line({}, 0, 0);
  const std::int64_t extremes[] = {std::numeric_limits<std::int64_t>::min(), std::numeric_limits<std::int64_t>::max(),
                                   0, -1};
  for (const std::int64_t device : extremes) {
    for (const std::int64_t pulse : extremes) {
      line.add(device, pulse);
      EXPECT_FALSE(std::isnan(line.at(pulse).error_ns));
    }
  }
}

}  // namespace
}  // namespace rigcal
