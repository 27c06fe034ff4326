#include "drivers/net/waiter.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "drivers/net/udp_socket.h"

namespace rigcal::net {
namespace {

TEST(Waiter, EndsWithTimeDataOrAWakeUp) {
  auto socket = UdpSocket::open({{{127, 0, 0, 1}, 0}, false, false, 0, {}});
  ASSERT_TRUE(socket.has_value());
  auto waiter = Waiter::create({socket->descriptor()});
  ASSERT_TRUE(waiter.has_value());
  EXPECT_FALSE(waiter->wait(1'000'000));
  EXPECT_FALSE(waiter->is_ready(0));
  const std::uint8_t byte = 7;
  ASSERT_TRUE(socket->send(socket->local(), {&byte, 1}).has_value());
  EXPECT_TRUE(waiter->wait(-1));
  EXPECT_TRUE(waiter->is_ready(0));
  ReceiveBatch batch(4);
  EXPECT_EQ(*socket->receive(batch), 1U);
  std::thread other([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    waiter->wake();
  });
  EXPECT_TRUE(waiter->wait(-1));
  EXPECT_FALSE(waiter->is_ready(0));
  other.join();
  // One that came before the wait counts, once.
  waiter->wake();
  waiter->wake();
  EXPECT_TRUE(waiter->wait(-1));
  EXPECT_FALSE(waiter->wait(0));
}

TEST(Waiter, RefusesMoreThanItCanHold) { EXPECT_FALSE(Waiter::create(std::vector<int>(65, 0)).has_value()); }

}  // namespace
}  // namespace rigcal::net
