#include "core/base/parallel_sort.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"

namespace rigcal {
namespace {

TEST(ParallelSort, SortsByKeyAndThenByNumber) {
  Random random(3);
  std::vector<std::pair<std::uint64_t, std::uint32_t>> items;
  for (std::uint32_t i = 0; i < 100000; ++i) items.emplace_back(random.below(5000), i);
  auto expected = items;
  std::sort(expected.begin(), expected.end());
  parallel_sort(items);
  EXPECT_TRUE(items == expected);
}

}  // namespace
}  // namespace rigcal
