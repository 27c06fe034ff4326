#include "core/base/radix_sort.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"

namespace rigcal {
namespace {

struct Item {
  std::uint64_t key = 0;
  std::uint32_t number = 0;
  bool operator==(const Item&) const = default;
};

std::vector<Item> items_with(std::uint32_t count, std::uint64_t below, unsigned shift) {
  Random random(3);
  std::vector<Item> items;
  for (std::uint32_t i = 0; i < count; ++i) items.push_back({(random.below(below) << shift) + 77, i});
  return items;
}

void expect_sorted(std::vector<Item> items) {
  std::vector<Item> expected = items;
  std::stable_sort(expected.begin(), expected.end(), [](const Item& a, const Item& b) { return a.key < b.key; });
  radix_sort(items);
  EXPECT_TRUE(items == expected);
}

TEST(RadixSort, SortsByKeyAndLeavesEqualOnesInTheirOrder) {
  expect_sorted(items_with(200'000, 5000, 0));  // more than a thread takes at a time
  expect_sorted(items_with(200'000, std::uint64_t{1} << 40, 0));
}

TEST(RadixSort, SortsByTheHighestBitsToo) {
  expect_sorted(items_with(1000, 16, 60));
  expect_sorted(items_with(1000, 300, 19));  // across the border of two digits
}

TEST(RadixSort, TakesFewAndEqualItems) {
  expect_sorted({});
  expect_sorted({{5, 1}});
  expect_sorted(items_with(100, 1, 0));
}

}  // namespace
}  // namespace rigcal
