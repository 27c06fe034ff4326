#include "core/camera/joint_histogram.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

struct Entry {
  std::uint8_t code;
  float grey;
};

JointHistogram histogram_of(const std::vector<Entry>& entries) {
  JointHistogram histogram;
  for (const Entry& e : entries) histogram.add(e.code, GreySpread(e.grey));
  return histogram;
}

TEST(GreySpread, SharesOneAmongThreeBins) {
  for (float g = -1.0F; g < 17.0F; g += 0.0625F) {
    const GreySpread s(g);
    EXPECT_GE(s.first, 0);
    EXPECT_LE(s.first + 2, grey_bins - 1);
    EXPECT_NEAR(s.weight[0] + s.weight[1] + s.weight[2], 1.0F, 1e-6F);
    EXPECT_NEAR(s.slope[0] + s.slope[1] + s.slope[2], 0.0F, 1e-6F);
    const float mean = s.weight[1] + 2.0F * s.weight[2] + static_cast<float>(s.first) - 1.0F;
    EXPECT_NEAR(mean, std::min(15.0F, std::max(0.0F, g)), 1e-5F);
  }
}

TEST(JointHistogram, IsNearWhereOneTellsTheOther) {
  Random random(1);
  std::vector<Entry> told;
  std::vector<Entry> blind;
  for (int k = 0; k < 50'000; ++k) {
    const auto code = static_cast<std::uint8_t>(random.below(4));
    told.push_back({code, 4.0F * static_cast<float>(code)});
    blind.push_back({code, 4.0F * static_cast<float>(random.below(4))});
  }
  EXPECT_LT(histogram_of(told).distance(), 0.5);  // spread over three bins, the grey value is not sharp
  EXPECT_GT(histogram_of(blind).distance(), 0.995);
  EXPECT_EQ(JointHistogram{}.distance(), 1.0);
  EXPECT_EQ(histogram_of({{3, 2.0F}, {3, 2.0F}}).total(), 2.0);
}

TEST(JointHistogram, DerivativeAgreesWithDifferences) {
  Random random(4);
  std::vector<Entry> entries;
  for (int k = 0; k < 400; ++k) {
    const auto code = static_cast<std::uint8_t>(random.below(surface_codes_count));
    entries.push_back({code, static_cast<float>(random.uniform(0.0, 8.0) + code * 0.03)});
  }
  std::vector<float> by_count;
  const double distance = histogram_of(entries).distance(by_count);
  EXPECT_DOUBLE_EQ(distance, histogram_of(entries).distance());
  for (std::size_t k = 0; k < 20; ++k) {
    const GreySpread spread(entries[k].grey);
    double expected = 0.0;
    for (std::size_t b = 0; b < 3; ++b) {
      expected += spread.slope[b] * by_count[entries[k].code * grey_bins + static_cast<std::size_t>(spread.first) + b];
    }
    std::vector<Entry> more = entries;
    std::vector<Entry> less = entries;
    more[k].grey += 0.02F;
    less[k].grey -= 0.02F;
    const double change = (histogram_of(more).distance() - histogram_of(less).distance()) / 0.04;
    EXPECT_NEAR(change * static_cast<double>(entries.size()), expected, 0.02 * std::abs(expected) + 0.01) << k;
  }
}

TEST(JointHistogram, AddsUp) {
  JointHistogram a = histogram_of({{1, 2.0F}, {7, 3.0F}});
  a += histogram_of({{2, 9.0F}});
  EXPECT_DOUBLE_EQ(a.distance(), histogram_of({{1, 2.0F}, {7, 3.0F}, {2, 9.0F}}).distance());
}

}  // namespace
}  // namespace rigcal
