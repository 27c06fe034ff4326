#include "apps/capture/thread_watch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

TEST(ThreadWatch, NamesWhoDoesNotMoveAndSaysWhenItDoesAgain) {
  Heartbeat stuck("stuck");
  Heartbeat busy("busy");
  Heartbeat resting("resting");
  Heartbeat unborn("unborn");
  ThreadWatch watch({&stuck, &busy, &resting, &unborn});
  for (Heartbeat* beat : {&stuck, &busy, &resting}) beat->beat();
  resting.rest();
  EXPECT_TRUE(watch.look().empty());
  const auto begun = std::chrono::steady_clock::now();
  while (std::chrono::steady_clock::now() - begun < std::chrono::milliseconds(3100)) {
    busy.beat();
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  auto news = watch.look();
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].thread, "stuck");
  EXPECT_THAT(news[0].text, HasSubstr("has not moved for 3 s"));
  EXPECT_THAT(watch.stuck(), ElementsAre("stuck"));
  EXPECT_TRUE(watch.look().empty());  // Told once.
  stuck.beat();
  news = watch.look();
  ASSERT_EQ(news.size(), 1U);
  EXPECT_EQ(news[0].text, "moves again");
  EXPECT_TRUE(watch.stuck().empty());

  SessionCounters counters;
  watch.count(counters);
  EXPECT_GE(counters["thread stuck"]["worst_pause_us"], 3'000'000U);
  EXPECT_EQ(counters["thread unborn"]["worst_pause_us"], 0U);
}

}  // namespace
}  // namespace rigcal
