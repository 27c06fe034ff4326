#include "core/base/spare_pool.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

TEST(SparePool, HandsOutWhatWasGivenBackAndElseANewOne) {
  SparePool<std::vector<int>> pool;
  auto first = pool.take(3U, 7);
  auto second = pool.take(2U, 1);
  EXPECT_EQ((std::vector<int>{7, 7, 7}), *first);
  EXPECT_EQ((std::vector<int>{1, 1}), *second);
  const std::vector<int>* const was = first.get();
  pool.give_back(std::move(first));
  EXPECT_EQ(was, pool.take(5U, 5).get());
}

TEST(SparePool, HasNoMoreItemsThanAreHeldAtOnce) {
  set_thread_count(2);
  SparePool<int> pool;
  std::atomic<int> held{0};
  parallel_for(1000, 1, [&](std::size_t, std::size_t) {
    std::unique_ptr<int> item = pool.take(0);
    EXPECT_EQ(1, ++*item) << "two threads hold it";
    ++held;
    --*item;
    pool.give_back(std::move(item));
  });
  EXPECT_EQ(1000, held);
  int items = 0;
  while (*pool.take(-1) == 0) ++items;
  EXPECT_GE(items, 1);
  EXPECT_LE(items, 2);
}

}  // namespace
}  // namespace rigcal
