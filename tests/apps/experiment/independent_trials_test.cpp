#include "apps/experiment/independent_trials.h"

#include <gtest/gtest.h>

#include <atomic>
#include <vector>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

TEST(IndependentTrials, EachIsTriedOnceWhateverTheNumberOfThreads) {
  const int before = thread_count();
  SilentReporter silent;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    std::vector<int> times(20, 0);
    const auto done = independent_trials(20, "trials", {silent}, [&](int k) -> Expected<void> {
      ++times[static_cast<std::size_t>(k)];
      return {};
    });
    EXPECT_TRUE(done);
    EXPECT_EQ(times, std::vector<int>(20, 1));
  }
  set_thread_count(before);
}

TEST(IndependentTrials, TellsTheFirstErrorAndStartsNoMore) {
  SilentReporter silent;
  std::atomic<int> tried = 0;
  const auto done = independent_trials(1000, "trials", {silent}, [&](int k) -> Expected<void> {
    ++tried;
    if (k < 5) return {};
    return input_error("trial " + std::to_string(k));
  });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().what, "trial 5");
  EXPECT_LT(tried.load(), 1000);
}

TEST(IndependentTrials, EndsWhenTold) {
  SilentReporter silent;
  std::stop_source stop;
  std::atomic<int> tried = 0;
  const auto done = independent_trials(1000, "trials", {silent, stop.get_token()}, [&](int) -> Expected<void> {
    ++tried;
    stop.request_stop();
    return {};
  });
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::cancelled);
  EXPECT_LT(tried.load(), 1000);
}

}  // namespace
}  // namespace rigcal
