// The driver on real loopback sockets against virtual devices.
#include "drivers/livox/device/driver.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <thread>

#include "drivers/livox_codec/sample_packet.h"
#include "simdata/live/virtual_livox.h"
#include "tests/support/allocation_counter.h"

namespace rigcal::livox {
namespace {

using testing::SizeIs;

/// A virtual device on its own address, with packets that carry no points.
class Unit {
 public:
  Unit(const std::string& code, DeviceType type, std::uint8_t last, std::uint16_t discovery_port)
      : unit_(options(code, type, last, discovery_port), net::read_clocks().monotonic_ns),
        control_(open({{127, 0, 0, last}, kDevicePort})),
        points_(open({{127, 0, 0, last}, kPointSourcePort})),
        batch_(16) {}

  void step() {
    const std::int64_t now_ns = net::read_clocks().monotonic_ns;
    std::vector<sim::DeviceFrame> out;
    unit_.tick(now_ns, out);
    const auto count = control_.receive(batch_);
    for (std::size_t i = 0; count && i < *count; ++i) unit_.receive(now_ns, batch_[i].from, batch_[i].bytes, out);
    for (const sim::DeviceFrame& frame : out) static_cast<void>(control_.send(frame.to, frame.bytes));
    if (!unit_.is_sampling() || unit_.is_silent(now_ns)) return;
    SampleHeader header;
    header.data_type = unit_.settings().point_type();
    header.device_stamp_ns = 400'000 * sent;
    std::vector<std::uint8_t> packet;
    encode_points(header, {}, packet);
    const auto done = points_.send({unit_.owner()->ip, unit_.owner()->data_port}, packet);
    if (done && *done) ++sent;
  }
  sim::VirtualLivox& device() { return unit_; }

  std::int64_t sent = 0;

 private:
  static sim::VirtualLivoxOptions options(const std::string& code, DeviceType type, std::uint8_t last,
                                          std::uint16_t discovery_port) {
    sim::VirtualLivoxOptions options;
    options.identity = {code, type, kDevicePort};
    options.ip = {127, 0, 0, last};
    options.broadcast_to = {{127, 0, 0, 1}, discovery_port};
    options.broadcast_s = 0.1;
    options.spin_up_s = 0.05;
    options.boot_s = 0.1;
    return options;
  }
  static net::UdpSocket open(const Endpoint& local) {
    auto made = net::UdpSocket::open({local, false, true, 0, {}});
    EXPECT_TRUE(made.has_value());
    return *std::move(made);
  }

  sim::VirtualLivox unit_;
  net::UdpSocket control_;
  net::UdpSocket points_;
  net::ReceiveBatch batch_;
};

constexpr std::uint16_t discovery_port = 55017;  // Not the usual one: another test may use that.

DriverOptions two_devices() {
  DriverOptions options;
  options.discovery_port = discovery_port;
  options.receive_bytes = 1 << 20;
  options.queue_datagrams = 4096;
  for (const char* code : {"3JEDHC900100791", "0TFDG3B00600551"}) {
    WantedDevice wanted;
    wanted.broadcast_code = code;
    wanted.ip = Ipv4{127, 0, 0, static_cast<std::uint8_t>(code[0] == '3' ? 201 : 202)};
    options.devices.push_back(wanted);
  }
  return options;
}

template <class Condition>
bool wait_for(const Condition& condition) {
  for (int i = 0; i < 1000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return false;
}

class LiveDriver : public testing::Test {
 protected:
  LiveDriver()
      : avia("3JEDHC900100791", DeviceType::avia, 201, discovery_port),
        mid40("0TFDG3B00600551", DeviceType::mid40, 202, discovery_port),
        network([this](const std::stop_token& stop) {
          while (!stop.stop_requested()) {
            {
              const std::lock_guard lock(mutex);
              avia.step();
              mid40.step();
            }
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
          }
        }) {}

  // Takes all datagrams while it waits.
  bool wait_for_sampling(Driver& driver, int devices) {
    return wait_for([&] {
      take(driver);
      int sampling = 0;
      for (const DeviceReport& report : driver.devices())
        if (report.link.state == LinkState::sampling && report.packets > 20) ++sampling;
      return sampling == devices;
    });
  }
  void take(Driver& driver) {
    Datagram datagram;
    while (driver.next(datagram, 0)) ++taken[datagram.from.ip[3]][datagram.from.port];
  }

  std::mutex mutex;
  Unit avia;
  Unit mid40;
  std::map<int, std::map<int, std::uint64_t>> taken;  ///< By the last number of the address, then by port.
  std::jthread network;
};

TEST_F(LiveDriver, TakesDevicesAndHandsOutEveryDatagram) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value()) << driver.error().message();
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  (*driver)->stop();
  take(**driver);
  EXPECT_FALSE((*driver)->is_running());
  const auto reports = (*driver)->devices();
  EXPECT_EQ(reports[0].link.firmware, (FirmwareVersion{11, 9, 0, 0}));
  EXPECT_EQ(reports[0].link.state, LinkState::closed);
  const auto interfaces = (*driver)->interfaces();
  ASSERT_THAT(interfaces, SizeIs(1));
  EXPECT_EQ(interfaces[0].counters.dropped_by_kernel + interfaces[0].counters.dropped_by_queue, 0U);
  const std::lock_guard lock(mutex);
  EXPECT_EQ(taken[201][kPointSourcePort], reports[0].packets);
  EXPECT_EQ(taken[202][kPointSourcePort], reports[1].packets);
  EXPECT_EQ(static_cast<std::uint64_t>(avia.sent + mid40.sent),
            interfaces[0].counters.received + interfaces[0].counters.strangers);
  // Both directions of control: broadcasts and acks of the devices, and what this host has sent.
  EXPECT_GT(taken[201][kDevicePort], 3U);
  EXPECT_GT(taken[1].size(), 0U);
  EXPECT_FALSE(avia.device().owner().has_value());
}

TEST_F(LiveDriver, AsksForNoMemoryBetweenTheSocketsAndWhoTakesThePackets) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value());
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  const std::uint64_t before = allocations_in_this_thread();
  const std::uint64_t before_in_receivers = allocations_in_receivers();
  int packets = 0;
  Datagram datagram;
  for (int i = 0; i < 5000 && packets < 1000; ++i)
    if ((*driver)->next(datagram, 100'000'000) && datagram.from.port == kPointSourcePort) ++packets;
  EXPECT_EQ(allocations_in_this_thread() - before, 0U);
  EXPECT_EQ(allocations_in_receivers() - before_in_receivers, 0U);
  EXPECT_EQ(packets, 1000);
}

TEST_F(LiveDriver, TakesADeviceAgainThatRestarts) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value());
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  {
    const std::lock_guard lock(mutex);
    avia.device().reboot(net::read_clocks().monotonic_ns);
  }
  ASSERT_TRUE(wait_for([&] {
    take(**driver);
    return (*driver)->devices()[0].link.counters.losses == 1;
  }));
  EXPECT_TRUE(wait_for_sampling(**driver, 2));
  const auto events = (*driver)->control().take_events();
  EXPECT_TRUE(std::any_of(events.begin(), events.end(),
                          [](const Event& event) { return std::holds_alternative<Lost>(event.content); }));
}

TEST_F(LiveDriver, AnswersWhatAUserAsks) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value());
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  static_cast<void>((*driver)->control().take_events());
  ASSERT_TRUE((*driver)->control().request(1, GetIpModeRequest{}).has_value());
  std::optional<GetIpModeAck> answer;
  EXPECT_TRUE(wait_for([&] {
    for (const Event& event : (*driver)->control().take_events()) {
      const auto* ended = std::get_if<RequestEnded>(&event.content);
      if (ended != nullptr && ended->command == Command::get_ip_mode) answer = std::get<GetIpModeAck>(ended->answer);
    }
    return answer.has_value();
  }));
  EXPECT_EQ(answer->ip, (Ipv4{127, 0, 0, 202}));
}

TEST_F(LiveDriver, WhatIsSentIsStampedWhenItWasSent) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value());
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  const std::int64_t before_ns =
      net::SessionClock((*driver)->session_start()).from_monotonic(net::read_clocks().monotonic_ns);
  ASSERT_TRUE((*driver)->control().request(1, GetIpModeRequest{}).has_value());
  std::optional<std::int64_t> stamp_ns;
  EXPECT_TRUE(wait_for([&] {
    Datagram datagram;
    while (!stamp_ns && (*driver)->next(datagram, 0)) {
      const auto frame = parse_control_frame(datagram.bytes);
      if (frame && command_of(*frame) == Command::get_ip_mode) stamp_ns = datagram.stamp_ns;
    }
    return stamp_ns.has_value();
  }));
  EXPECT_GE(stamp_ns.value_or(0), before_ns);
}

TEST_F(LiveDriver, StopsWithinTwoSecondsWhateverTheDevicesDo) {
  auto driver = Driver::start(two_devices());
  ASSERT_TRUE(driver.has_value());
  ASSERT_TRUE(wait_for_sampling(**driver, 2));
  {
    const std::lock_guard lock(mutex);
    avia.device().fall_silent(INT64_MAX);
  }
  const auto start = std::chrono::steady_clock::now();
  (*driver)->stop();
  EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(2));
}

TEST(DriverStart, SaysWhatKeepsItFromStarting) {
  DriverOptions options = two_devices();
  options.interface = "nosuchif0";
  const auto refused = Driver::start(options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error().kind, ErrorKind::system);
}

TEST(DriverStart, TellsOfPrivilegesAndBuffersThatAreMissing) {
  DriverOptions options = two_devices();
  options.receive_bytes = 1U << 30U;
  auto driver = Driver::start(options);
  ASSERT_TRUE(driver.has_value());
  const auto interfaces = (*driver)->interfaces();
  EXPECT_EQ((*driver)->notes().size(), interfaces[0].receive_bytes < options.receive_bytes ? 1U : 0U);
}

}  // namespace
}  // namespace rigcal::livox
