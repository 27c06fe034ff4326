#include "drivers/trigger/event_queue.h"

#include <gtest/gtest.h>

#include <thread>

namespace rigcal::trigger {
namespace {

TriggerEvent numbered(std::int64_t number) { return {TriggerSource::output, TriggerEventKind::pulse, number, 0}; }

TEST(EventQueue, KeepsTheOrderAndCountsWhatHasNoRoom) {
  EventQueue queue(3);
  for (std::int64_t i = 0; i < 5; ++i) queue.push(numbered(i));
  EXPECT_EQ(queue.dropped(), 2U);
  TriggerEvent event;
  for (std::int64_t i = 0; i < 3; ++i) {
    ASSERT_TRUE(queue.take(event, 0));
    EXPECT_EQ(event.number, i);
  }
  EXPECT_FALSE(queue.take(event, 0));
  queue.push(numbered(7));
  ASSERT_TRUE(queue.take(event, 0));
  EXPECT_EQ(event.number, 7);
}

TEST(EventQueue, WakesWhoWaitsAndEndsTheWaitWhenItIsClosed) {
  EventQueue queue(3);
  std::thread other([&queue] { queue.push(numbered(1)); });
  TriggerEvent event;
  EXPECT_TRUE(queue.take(event, 10'000'000'000));
  other.join();
  queue.push(numbered(2));
  queue.close();
  EXPECT_TRUE(queue.take(event, 10'000'000'000));  // What was there is still handed out.
  EXPECT_FALSE(queue.take(event, 10'000'000'000));
}

}  // namespace
}  // namespace rigcal::trigger
