#include "core/base/parallel.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cmath>

namespace rigcal {
namespace {

TEST(ParallelFor, CoversEveryIndexOnce) {
  std::vector<std::atomic<int>> seen(1003);
  parallel_for(seen.size(), 10, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) ++seen[i];
  });
  for (const auto& count : seen) EXPECT_EQ(count.load(), 1);
}

TEST(ParallelSum, IsTheSameToTheBitForAnyNumberOfThreads) {
  const auto sum = [] {
    return parallel_sum(100000, 1000, 0.0, [](std::size_t begin, std::size_t end) {
      double part = 0.0;
      for (std::size_t i = begin; i < end; ++i) part += std::sin(static_cast<double>(i)) / 3.0;
      return part;
    });
  };
  set_thread_count(1);
  const double one = sum();
  for (const int threads : {2, 3, 8}) {
    set_thread_count(threads);
    EXPECT_EQ(sum(), one) << threads << " threads";
  }
}

}  // namespace
}  // namespace rigcal
