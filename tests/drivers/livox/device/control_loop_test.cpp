// The talk with the devices on real loopback sockets: what gets lost of it here is counted, by reason.
#include "drivers/livox/device/control_loop.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <functional>
#include <thread>

namespace rigcal::livox {
namespace {

constexpr std::uint16_t discovery_port = 55019;  // Not the usual one: other tests run at the same time.
constexpr Ipv4 host_ip{127, 0, 0, 1};
constexpr Ipv4 device_ip{127, 0, 0, 211};
constexpr const char* wanted_code = "3JEDHC900100791";

class ControlLoopTest : public testing::Test {
 protected:
  void SetUp() override {
    const auto interfaces = net::list_interfaces();
    ASSERT_TRUE(interfaces.has_value());
    const auto loopback = std::find_if(interfaces->begin(), interfaces->end(),
                                       [](const net::Interface& each) { return each.ip == host_ip; });
    if (loopback == interfaces->end()) GTEST_SKIP() << "no loopback interface";
    ControlLoop::Wiring wiring;
    wiring.hosts = {*loopback};
    wiring.data_ports = {56001};
    wiring.devices.resize(1);
    wiring.devices[0].broadcast_code = wanted_code;
    wiring.discovery_port = discovery_port;
    wiring.session_start = net::read_clocks();
    wiring.prepare = [this](std::size_t host) { prepared += host == 0 ? 1 : 100; };
    auto opened = ControlLoop::open(std::move(wiring), senders);
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
    loop = *std::move(opened);
    auto socket = net::UdpSocket::open({{device_ip, kDevicePort}, false, false, 0, {}});
    ASSERT_TRUE(socket.has_value()) << socket.error().message();
    device = std::make_unique<net::UdpSocket>(*std::move(socket));
  }
  void TearDown() override {
    if (!thread.joinable()) return;
    loop->leave();
    thread.join();
  }
  void run() {
    thread = std::thread([this] { loop->run(); });
  }
  void say(ByteView bytes) const { ASSERT_TRUE(device->send({host_ip, discovery_port}, bytes).has_value()); }
  /// Whether the counters come to be so within five seconds.
  bool comes_to(const std::function<bool(const ControlCounters&)>& condition) const {
    for (int i = 0; i < 1000; ++i) {
      if (condition(loop->counters())) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return false;
  }

  Senders senders;
  std::atomic<int> prepared = 0;
  std::unique_ptr<ControlLoop> loop;
  std::unique_ptr<net::UdpSocket> device;
  std::thread thread;
};

TEST_F(ControlLoopTest, CountsWhatTheKernelHadNoRoomForAndWhatIsNoFrame) {
  constexpr std::uint64_t sent = 5000;  // Some hundreds fit into the buffer while nobody takes them.
  const std::vector<std::uint8_t> bytes(40, 0xAA);
  for (std::uint64_t i = 0; i < sent; ++i) say(bytes);
  run();
  EXPECT_TRUE(comes_to([](const ControlCounters& counters) {
    return counters.protocol.malformed + counters.dropped_by_kernel == sent;
  }));
  EXPECT_GT(loop->counters().protocol.malformed, 0U);
  EXPECT_GT(loop->counters().dropped_by_kernel, 0U);
  EXPECT_EQ(loop->counters().receive_errors, 0U);
}

TEST_F(ControlLoopTest, CountsFramesOfNobodyAndEventsThatNobodyTook) {
  run();
  say(encode_control(HandshakeAck{}, 1));
  EXPECT_TRUE(comes_to([](const ControlCounters& counters) { return counters.protocol.strangers == 1; }));
  for (int i = 0; i < 20'000 && loop->counters().lost_events == 0; ++i) {
    std::string code = "0TFDG3B00000000";
    const std::string number = std::to_string(i);
    code.replace(code.size() - number.size(), number.size(), number);
    say(make_broadcast({code, DeviceType::mid40, 0}, 1));  // Each is a device that was not seen before.
  }
  EXPECT_TRUE(comes_to([](const ControlCounters& counters) { return counters.lost_events > 0; }));
  EXPECT_EQ(loop->take_events().size(), ControlLoop::kMostEvents);
}

TEST_F(ControlLoopTest, PreparesAHostOnceADeviceThatIsWantedIsHeardThere) {
  run();
  const auto wait_for = [](const std::function<bool()>& condition) {
    for (int i = 0; i < 1000 && !condition(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    return condition();
  };
  say(make_broadcast({"0TFDG3B00600999", DeviceType::mid40, 0}, 1));
  EXPECT_TRUE(wait_for([&] { return !loop->sightings().empty(); }));
  EXPECT_EQ(prepared, 0);
  for (int i = 0; i < 20; ++i) {
    say(make_broadcast({wanted_code, DeviceType::avia, 0}, 1));
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  EXPECT_TRUE(wait_for([&] { return prepared > 0; }));
  EXPECT_EQ(prepared, 1);
}

// A broadcast that says it came from port 0, where no answer can be sent to.
bool say_from_port_zero(ByteView bytes) {
  const int raw = socket(AF_INET, SOCK_RAW, IPPROTO_UDP);
  if (raw < 0) return false;
  const auto address_of = [](const Ipv4& ip) {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    std::memcpy(&address.sin_addr, ip.data(), ip.size());
    return address;
  };
  const sockaddr_in from = address_of(device_ip);
  const sockaddr_in to = address_of(host_ip);
  const auto length = static_cast<std::uint16_t>(8 + bytes.size());
  std::vector<std::uint8_t> datagram{0,
                                     0,
                                     discovery_port >> 8U,
                                     discovery_port & 0xFFU,
                                     static_cast<std::uint8_t>(length >> 8U),
                                     static_cast<std::uint8_t>(length),
                                     0,
                                     0};
  datagram.insert(datagram.end(), bytes.begin(), bytes.end());
  const bool is_sent = bind(raw, reinterpret_cast<const sockaddr*>(&from), sizeof from) == 0 &&
                       sendto(raw, datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                              sizeof to) == static_cast<ssize_t>(datagram.size());
  close(raw);
  return is_sent;
}

TEST_F(ControlLoopTest, CountsFramesThatTheSystemRefusesToSend) {
  run();
  if (!say_from_port_zero(make_broadcast({wanted_code, DeviceType::avia, 0}, 1)))
    GTEST_SKIP() << "no permission for raw sockets";
  EXPECT_TRUE(comes_to([](const ControlCounters& counters) { return counters.send_errors == 1; }));
  EXPECT_EQ(loop->ring().pushed(), 1U);  // What came, and not what was not sent.
}

}  // namespace
}  // namespace rigcal::livox
