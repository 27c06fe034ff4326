// Sockets on loopback addresses.
#include "drivers/net/udp_socket.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>

#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include "drivers/net/session_clock.h"
#include "drivers/net/socket_limits.h"

namespace rigcal::net {
namespace {

using testing::HasSubstr;

UdpSocket open(UdpOptions options) {
  auto made = UdpSocket::open(options);
  EXPECT_TRUE(made.has_value());
  return *std::move(made);
}

UdpSocket open_at(std::uint8_t last) { return open({{{127, 0, 0, last}, 0}, false, false, 0, {}}); }

TEST(UdpSocket, BringsDatagramsWithStampsAndAddresses) {
  UdpSocket host = open({{{0, 0, 0, 0}, 0}, true, false, 0, {}});
  const UdpSocket device = open_at(179);
  const std::int64_t before = read_clocks().realtime_ns;
  for (std::uint8_t i = 0; i < 5; ++i) {
    const std::vector<std::uint8_t> bytes(i + 1U, i);
    ASSERT_TRUE(*device.send({{127, 0, 0, 1}, host.local().port}, bytes));
  }
  ReceiveBatch batch(16);
  ASSERT_EQ(*host.receive(batch), 5U);
  const std::int64_t after = read_clocks().realtime_ns;
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(batch[i].bytes.size(), i + 1);
    EXPECT_EQ(batch[i].bytes[0], i);
    EXPECT_EQ(batch[i].from, device.local());
    EXPECT_EQ(batch[i].to, (Endpoint{{127, 0, 0, 1}, host.local().port}));
    EXPECT_EQ(batch[i].local_ip, (std::array<std::uint8_t, 4>{127, 0, 0, 1}));
    EXPECT_GT(batch[i].interface, 0);
    EXPECT_GE(batch[i].realtime_ns, before - 10'000'000);
    EXPECT_LE(batch[i].realtime_ns, after + 10'000'000);
    EXPECT_GE(batch[i].realtime_ns, batch[i == 0 ? 0 : i - 1].realtime_ns);
  }
  EXPECT_EQ(*host.receive(batch), 0U);
  EXPECT_EQ(host.dropped(), 0U);
}

TEST(UdpSocket, SendsManyAtOnceInTwoPartsEach) {
  UdpSocket host = open_at(1);
  const UdpSocket device = open_at(179);
  std::vector<std::vector<std::uint8_t>> heads;
  const std::vector<std::uint8_t> body(700, 7);
  for (std::size_t i = 0; i < 100; ++i) heads.push_back({static_cast<std::uint8_t>(i), 1});
  std::vector<Parts> parts;
  for (std::size_t i = 0; i < heads.size(); ++i) parts.push_back({host.local(), heads[i], ByteView(body).first(i)});
  ASSERT_EQ(*device.send_all(parts), 100U);
  ReceiveBatch batch(128);
  ASSERT_EQ(*host.receive(batch), 100U);
  for (std::size_t i = 0; i < 100; ++i) {
    ASSERT_EQ(batch[i].bytes.size(), 2 + i);
    EXPECT_EQ(batch[i].bytes[0], i);
    EXPECT_EQ(batch[i].bytes.back(), i == 0 ? 1 : 7);
  }
  EXPECT_EQ(*device.send_all({}), 0U);
}

TEST(UdpSocket, WhatIsTooLongForTheWayIsLostAndTheRestIsNot) {
  UdpSocket host = open_at(1);
  const UdpSocket device = open_at(179);
  device.set_do_not_fragment(true);
  const std::vector<std::uint8_t> bytes(70'000);
  const std::vector<Parts> parts{{host.local(), ByteView(bytes).first(1), {}},
                                 {host.local(), bytes, {}},
                                 {host.local(), ByteView(bytes).first(3), {}}};
  EXPECT_EQ(*device.send_all(parts), 2U);
  ReceiveBatch batch(4);
  ASSERT_EQ(*host.receive(batch), 2U);
  EXPECT_EQ(batch[1].bytes.size(), 3U);
}

TEST(UdpSocket, TellsTheInterfaceOfABroadcast) {
  UdpSocket host = open({{{0, 0, 0, 0}, 0}, true, false, 0, {}});
  const UdpSocket device = open({{{127, 0, 0, 21}, 0}, false, true, 0, {}});
  const std::uint8_t byte = 1;
  ASSERT_TRUE(*device.send({{127, 255, 255, 255}, host.local().port}, {&byte, 1}));
  ReceiveBatch batch(4);
  ASSERT_EQ(*host.receive(batch), 1U);
  EXPECT_EQ(batch[0].to.ip, (std::array<std::uint8_t, 4>{127, 255, 255, 255}));
  EXPECT_EQ(batch[0].local_ip[0], 127);
  EXPECT_NE(batch[0].local_ip, batch[0].to.ip);
}

TEST(UdpSocket, CountsEveryDatagramThatTheKernelDropped) {
  UdpSocket host = open({{{127, 0, 0, 1}, 0}, false, false, 64 * 1024, {}});
  const UdpSocket device = open_at(21);
  const std::vector<std::uint8_t> bytes(1318, 7);
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  ReceiveBatch batch(64);
  const auto drain = [&] {
    while (*host.receive(batch) > 0) received += batch.size();
  };
  for (int burst = 0; burst < 3; ++burst) {
    for (int i = 0; i < 500; ++i, ++sent) ASSERT_TRUE(*device.send(host.local(), bytes));
    drain();
  }
  EXPECT_LT(received, sent);
  EXPECT_EQ(received + host.dropped(), sent);
}

TEST(UdpSocket, TellsDestinationsWhereAsked) {
  UdpOptions options;
  options.local = {{127, 0, 0, 1}, 0};
  options.tell_destination = false;
  UdpSocket host = open(options);
  const UdpSocket device = open_at(21);
  const std::uint8_t byte = 1;
  ASSERT_TRUE(*device.send(host.local(), {&byte, 1}));
  ReceiveBatch batch(2);
  ASSERT_EQ(*host.receive(batch), 1U);
  EXPECT_EQ(batch[0].to, host.local());
  EXPECT_EQ(batch[0].from, device.local());
  EXPECT_EQ(batch[0].interface, 0);
  EXPECT_NE(batch[0].realtime_ns, 0);
}

TEST(UdpSocket, ABigBufferHoldsABurst) {
  UdpSocket host = open({{{127, 0, 0, 1}, 0}, false, false, 4 << 20, {}});
  if (host.receive_bytes() < (4 << 20)) {
    EXPECT_EQ(host.receive_bytes(), *largest_receive_buffer());
    EXPECT_THAT(receive_buffer_hint(4 << 20, host.receive_bytes()), HasSubstr("net.core.rmem_max=4194304"));
    return;
  }
  const UdpSocket device = open_at(21);
  const std::vector<std::uint8_t> bytes(1318, 7);
  for (int i = 0; i < 1000; ++i) ASSERT_TRUE(*device.send(host.local(), bytes));
  ReceiveBatch batch(64);
  std::size_t received = 0;
  while (*host.receive(batch) > 0) received += batch.size();
  EXPECT_EQ(received, 1000U);
}

TEST(UdpSocket, MarksADatagramThatIsTooLong) {
  UdpSocket host = open_at(1);
  const std::vector<std::uint8_t> bytes(5000, 7);
  ASSERT_TRUE(*host.send(host.local(), bytes));
  ReceiveBatch batch(2);
  ASSERT_EQ(*host.receive(batch), 1U);
  EXPECT_TRUE(batch[0].truncated);
  EXPECT_EQ(batch[0].bytes.size(), ReceiveBatch::kDatagramBytes);
}

TEST(UdpSocket, SendingToNobodyIsNoFault) {
  UdpSocket host = open_at(1);
  std::uint16_t closed_port = 0;
  { closed_port = open_at(1).local().port; }
  const std::uint8_t byte = 1;
  EXPECT_TRUE(host.send({{127, 0, 0, 1}, closed_port}, {&byte, 1}).has_value());
  ReceiveBatch batch(2);
  EXPECT_EQ(*host.receive(batch), 0U);
}

TEST(UdpSocket, SaysWhyItCannotListen) {
  const UdpSocket taken = open_at(1);
  const auto again = UdpSocket::open({taken.local(), false, false, 0, {}});
  ASSERT_FALSE(again.has_value());
  EXPECT_EQ(again.error().kind, ErrorKind::system);
  EXPECT_THAT(again.error().message(), HasSubstr("another program has the port"));
  const auto nowhere = UdpSocket::open({{{203, 0, 113, 77}, 0}, false, false, 0, {}});
  ASSERT_FALSE(nowhere.has_value());
  EXPECT_THAT(nowhere.error().message(), HasSubstr("no interface of this machine has that address"));
  EXPECT_FALSE(UdpSocket::open({{{127, 0, 0, 1}, 0}, false, false, 0, "nosuchif0"}).has_value());
}

TEST(UdpSocket, TwoMayShareAPortWhereAsked) {
  const UdpSocket first = open({{{0, 0, 0, 0}, 0}, true, false, 0, {}});
  EXPECT_TRUE(UdpSocket::open({first.local(), true, false, 0, {}}).has_value());
}

// In a network of this thread's own, which a process that it starts is in, too; false where the system gives none.
template <class F>
bool in_own_network(const F& f) {
  bool given = false;
  std::thread([&] {
    given = unshare(CLONE_NEWNET) == 0;
    if (given) given = f();
  }).join();
  return given;
}

bool runs(const std::string& command) { return std::system((command + " >/dev/null 2>&1").c_str()) == 0; }

// A pair of adapters and the way between them.
bool plug_in(const std::string& name) {
  return runs("ip link add " + name + " type veth peer name " + name + "_far") &&
         runs("ip address add 10.55.0.1/24 dev " + name) && runs("ip link set " + name + " up") &&
         runs("ip link set " + name + "_far up");
}

TEST(UdpSocket, FollowsAnAdapterThatIsPluggedInAnew) {
  const bool given = in_own_network([] {
    if (!plug_in("usb0")) return false;
    UdpSocket host = open({{{10, 55, 0, 1}, 0}, false, false, 0, "usb0"});
    EXPECT_FALSE(host.follow_interface());
    const auto has_a_way = [&] {
      const std::uint8_t byte = 1;
      const auto sent = host.send({{10, 55, 0, 2}, 65000}, {&byte, 1});
      return sent.has_value() && *sent;
    };
    EXPECT_TRUE(has_a_way());
    EXPECT_TRUE(runs("ip link delete usb0"));
    EXPECT_FALSE(host.follow_interface());
    EXPECT_FALSE(has_a_way());
    EXPECT_TRUE(runs("ip link add other0 type veth peer name other1"));  // takes the old one's number, if any does
    EXPECT_TRUE(plug_in("usb0"));
    EXPECT_FALSE(has_a_way());
    EXPECT_TRUE(host.follow_interface());
    EXPECT_TRUE(has_a_way());
    EXPECT_FALSE(host.follow_interface());
    return true;
  });
  if (!given) GTEST_SKIP() << "this system gives no network of its own, or no program `ip` to make adapters with";
}

}  // namespace
}  // namespace rigcal::net
