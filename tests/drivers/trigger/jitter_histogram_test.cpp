#include "drivers/trigger/jitter_histogram.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <limits>

namespace rigcal::trigger {
namespace {

using testing::HasSubstr;

TEST(JitterHistogram, CountsByDistanceAndKeepsTheFigures) {
  JitterHistogram histogram;
  for (const std::int64_t off : {500, 1'000, 1'001, -1'500, 80'000'000}) histogram.add(off);
  EXPECT_EQ(histogram.count(), 5U);
  EXPECT_EQ(histogram.bin(0), 2U);
  EXPECT_EQ(histogram.bin(1), 2U);
  EXPECT_EQ(histogram.bin(JitterHistogram::kEnds_ns.size()), 1U);
  EXPECT_EQ(histogram.least_ns(), -1'500);
  EXPECT_EQ(histogram.most_ns(), 80'000'000);
}

TEST(JitterHistogram, HasMeanAndDeviation) {
  JitterHistogram histogram;
  EXPECT_EQ(histogram.deviation_ns(), 0.0);
  for (const std::int64_t off : {10'000, 20'000, 30'000}) histogram.add(off);
  EXPECT_DOUBLE_EQ(histogram.mean_ns(), 20'000.0);
  EXPECT_NEAR(histogram.deviation_ns(), 8'165.0, 1.0);
}

TEST(JitterHistogram, TakesAnyTime) {
  JitterHistogram histogram;
  histogram.add(std::numeric_limits<std::int64_t>::min());
  histogram.add(std::numeric_limits<std::int64_t>::max());
  EXPECT_EQ(histogram.bin(JitterHistogram::kEnds_ns.size()), 2U);
}

TEST(JitterHistogram, ShowsTheBinsThatHaveSomething) {
  JitterHistogram histogram;
  EXPECT_EQ(histogram.text(), "no pulses\n");
  for (int i = 0; i < 100; ++i) histogram.add(15'000);
  for (int i = 0; i < 50; ++i) histogram.add(90'000);
  histogram.add(60'000'000);
  EXPECT_EQ(histogram.text().find("<= 10 us"), std::string::npos);
  EXPECT_THAT(histogram.text(), HasSubstr("<= 20 us         100 " + std::string(50, '#') + "\n"));
  EXPECT_THAT(histogram.text(), HasSubstr("<= 50 us           0 \n"));
  EXPECT_THAT(histogram.text(), HasSubstr("<= 100 us         50 " + std::string(25, '#') + "\n"));
  EXPECT_THAT(histogram.text(), HasSubstr(">  50 ms           1 #\n"));
  EXPECT_THAT(histogram.text(), HasSubstr("151 pulses: mean 437.1 us"));
}

}  // namespace
}  // namespace rigcal::trigger
