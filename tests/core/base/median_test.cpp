#include "core/base/median.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(Median, IsTheLargerOfTwoInTheMiddleAndZeroOfNone) {
  EXPECT_EQ(median(std::vector<int>{5, 1, 3}), 3);
  EXPECT_EQ(median(std::vector<double>{4.0, 1.0, 3.0, 2.0}), 3.0);
  EXPECT_EQ(median(std::vector<double>{}), 0.0);
}

TEST(Median, QuantilesAreOfTheNumbersThemselves) {
  std::vector<float> values{30.0F, 10.0F, 0.0F, 40.0F, 20.0F};
  EXPECT_EQ(quantile(values, 0.0), 0.0F);
  EXPECT_EQ(quantile(values, 0.25), 10.0F);
  EXPECT_EQ(quantile(values, 0.99), 30.0F) << "not between two";
  EXPECT_EQ(quantile(values, 1.0), 40.0F);
  EXPECT_EQ(of_rank(values, 2), 20.0F);
}

}  // namespace
}  // namespace rigcal
