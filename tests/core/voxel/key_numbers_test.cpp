#include "core/voxel/key_numbers.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

TEST(KeyNumbers, GoOnCountingWhileTheTableGrows) {
  KeyNumbers numbers;
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const auto met = numbers.meet(i * i * 977);
    ASSERT_TRUE(met.first);
    ASSERT_EQ(met.number, i);
  }
  for (std::uint64_t i = 0; i < 5000; ++i) {
    const auto met = numbers.meet(i * i * 977);
    ASSERT_FALSE(met.first);
    ASSERT_EQ(met.number, i);
    ASSERT_EQ(numbers.find(i * i * 977), i);
  }
  EXPECT_EQ(numbers.find(5), KeyNumbers::unknown);
  EXPECT_EQ(numbers.size(), 5000U);
}

}  // namespace
}  // namespace rigcal
