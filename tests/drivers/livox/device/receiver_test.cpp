// The thread that receives: no memory, no loss that is not counted.
#include "drivers/livox/device/receiver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "core/io/pcapng_writer.h"
#include "tests/support/allocation_counter.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::livox {
namespace {

constexpr std::int64_t ms = 1'000'000;

class Receiving : public testing::Test {
 protected:
  void open(std::size_t receive_bytes, std::size_t queue) {
    net::UdpOptions options;
    options.local = {{127, 0, 0, 1}, 0};
    options.receive_bytes = receive_bytes;
    auto made = Receiver::open(options, senders, net::read_clocks(), queue);
    ASSERT_TRUE(made.has_value());
    receiver = *std::move(made);
    receiver->prepare();
    senders.set(3, {127, 0, 0, 21});
    options.local = {{127, 0, 0, 21}, 0};
    options.receive_bytes = 0;
    auto socket = net::UdpSocket::open(options);
    ASSERT_TRUE(socket.has_value());
    device = std::make_unique<net::UdpSocket>(*std::move(socket));
  }
  void send(int count) const {
    const std::vector<std::uint8_t> bytes(1362, 5);
    for (int i = 0; i < count; ++i) ASSERT_TRUE(*device->send(receiver->socket().local(), bytes));
  }
  std::uint64_t drain() const {
    Datagram datagram;
    std::uint64_t count = 0;
    for (; receiver->ring().peek(datagram); ++count) receiver->ring().pop();
    return count;
  }

  Senders senders;
  std::unique_ptr<Receiver> receiver;
  std::unique_ptr<net::UdpSocket> device;
};

TEST_F(Receiving, AsksForNoMemory) {
  open(1 << 20, 4096);
  std::vector<std::uint8_t> bytes(1362, 5);
  const Endpoint to = receiver->socket().local();
  const std::uint64_t before = allocations_in_this_thread();
  std::uint64_t received = 0;
  for (int burst = 0; burst < 50; ++burst) {
    for (int i = 0; i < 20; ++i) received += device->send(to, bytes).has_value() ? 1 : 0;
    receiver->receive_some(ms);
    EXPECT_EQ(drain(), 20U);
  }
  EXPECT_EQ(allocations_in_this_thread() - before, 0U);
  EXPECT_EQ(receiver->counters().received, received);
  EXPECT_EQ(receiver->traffic(3).packets.load(), received);
  EXPECT_EQ(receiver->traffic(3).bytes.load(), received * 1362);
}

TEST_F(Receiving, AsksForNoMemoryOnTheWayToTheDisk) {
  open(1 << 20, 4096);
  auto recorder = PcapngWriter::create(fresh_path("recorded.pcapng"));
  ASSERT_TRUE(recorder.has_value());
  const std::vector<std::uint8_t> bytes(1362, 5);
  const Endpoint to = receiver->socket().local();
  const std::uint64_t before = allocations_in_this_thread();
  for (int burst = 0; burst < 100; ++burst) {  // 2.7 MB: the writer's buffer is emptied twice.
    for (int i = 0; i < 20; ++i) ASSERT_TRUE(*device->send(to, bytes));
    receiver->receive_some(ms);
    for (Datagram datagram; receiver->ring().peek(datagram); receiver->ring().pop())
      ASSERT_TRUE(recorder->write(datagram).has_value());
  }
  ASSERT_TRUE(recorder->flush().has_value());
  EXPECT_EQ(allocations_in_this_thread() - before, 0U);
  EXPECT_EQ(recorder->datagrams(), 2000U);
}

TEST(GatheringPause, LeavesRoomAtAnyRateAndIsLongAtLowOnes) {
  const auto settle = [](double packets_per_ms, std::size_t room) {
    std::int64_t pause_ns = kLongestPauseNs;
    for (int i = 0; i < 50; ++i) {
      // Never less than 50 us: that is how long a round takes.
      const double passed_ms = std::max(1e-6 * static_cast<double>(pause_ns), 0.05);
      pause_ns = gathering_pause_ns(pause_ns, static_cast<std::size_t>(packets_per_ms * passed_ms), room);
    }
    return pause_ns;
  };
  constexpr std::size_t small = 92;    // The kernel's default.
  constexpr std::size_t large = 7000;  // 8 MiB
  for (const double times : {0.01, 0.2, 1.0, 5.0, 20.0, 100.0}) {
    const double packets_per_ms = 5.5 * times;
    for (const std::size_t room : {small, large}) {
      const std::int64_t pause_ns = settle(packets_per_ms, room);
      EXPECT_LE(packets_per_ms * 1e-6 * static_cast<double>(pause_ns), static_cast<double>(room) / 3.0 + 1.0) << times;
    }
  }
  EXPECT_EQ(settle(5.5, large), kLongestPauseNs);
  EXPECT_GE(settle(5.5, small), 2'000'000);
  EXPECT_EQ(settle(5.5 * 20, large), kLongestPauseNs);
}

TEST_F(Receiving, StampsAreSessionTime) {
  open(1 << 20, 64);
  const std::int64_t before = net::read_clocks().realtime_ns;
  send(1);
  receiver->receive_some(100 * ms);
  Datagram datagram;
  ASSERT_TRUE(receiver->ring().peek(datagram));
  EXPECT_NEAR(static_cast<double>(datagram.stamp_ns - before), 0.0, 100e6);
  EXPECT_EQ(datagram.from, device->local());
  EXPECT_EQ(datagram.to, receiver->socket().local());
  EXPECT_EQ(receiver->traffic(3).last_ns.load(), datagram.stamp_ns);
}

TEST_F(Receiving, CountsEveryLossWhereItHappens) {
  open(64 * 1024, 64);
  int sent = 0;
  std::uint64_t taken = 0;
  for (int burst = 0; burst < 5; ++burst) {
    send(300);
    sent += 300;
    receiver->receive_some(ms);
    taken += drain();
  }
  const ReceiverCounters counters = receiver->counters();
  EXPECT_GT(counters.dropped_by_kernel, 0U);
  EXPECT_EQ(counters.received, taken);
  EXPECT_EQ(counters.received + counters.dropped_by_kernel + counters.dropped_by_queue,
            static_cast<std::uint64_t>(sent));
}

TEST_F(Receiving, LeavesStrangersOut) {
  open(1 << 20, 64);
  senders.clear(3);
  send(5);
  receiver->receive_some(ms);
  EXPECT_EQ(receiver->counters().strangers, 5U);
  EXPECT_EQ(drain(), 0U);
  EXPECT_EQ(senders.find({0, 0, 0, 0}), kNoDevice);
  senders.set(3, {127, 0, 0, 21});
  senders.set(5, {127, 0, 0, 21});  // Another device has this address now.
  EXPECT_EQ(senders.find({127, 0, 0, 21}), 5U);
  senders.clear(5);
  EXPECT_EQ(senders.find({127, 0, 0, 21}), kNoDevice);
}

}  // namespace
}  // namespace rigcal::livox
