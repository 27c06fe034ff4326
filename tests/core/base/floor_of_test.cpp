#include "core/base/floor_of.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace rigcal {
namespace {

TEST(FloorOf, IsTheFloor) {
  for (const double value : {-2.0, -1.5, -1.0, -1e-9, -0.0, 0.0, 1e-9, 0.5, 1.0, 1e15, -1e15 - 0.5})
    EXPECT_EQ(floor_of(value), static_cast<std::int64_t>(std::floor(value))) << value;
  Random random(7);
  for (int i = 0; i < 10000; ++i) {
    const double value = 1e6 * (random.uniform() - 0.5);
    ASSERT_EQ(floor_of(value), static_cast<std::int64_t>(std::floor(value))) << value;
  }
}

}  // namespace
}  // namespace rigcal
