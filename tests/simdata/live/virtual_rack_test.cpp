// Virtual devices on sockets of their own, and what happens to them.
#include "simdata/live/virtual_rack.h"

#include <gtest/gtest.h>

#include "drivers/net/session_clock.h"

namespace rigcal::sim {
namespace {

constexpr std::int64_t second_ns = 1'000'000'000;

// An address of their own: other tests run at the same time.
RackDevice device_at(std::uint8_t last, const std::string& name) {
  RackDevice device;
  device.name = name;
  device.point_source = {{127, 7, 31, last}, livox::kPointSourcePort};
  device.imu_source = {{127, 7, 31, last}, livox::kImuSourcePort};
  device.firmware.identity = {"3JEDRCK000000" + std::to_string(10 + last % 90), livox::DeviceType::avia, 0};
  device.firmware.ip = device.point_source.ip;
  device.firmware.spin_up_s = 0.0;
  device.firmware.broadcast_to = {{127, 7, 31, 200}, 9};
  return device;
}

class Rack : public testing::Test {
 protected:
  void open(const std::vector<std::string>& incidents) {
    RackOptions options;
    for (const std::string& text : incidents) {
      const auto incident = parse_incident(text);
      ASSERT_TRUE(incident.has_value()) << incident.error().message();
      options.incidents.push_back(*incident);
    }
    auto opened = VirtualRack::open({device_at(1, "left"), device_at(2, "right")}, options);
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
    rack = *std::move(opened);
    start_ns = net::read_clocks().monotonic_ns;
  }
  void at(double time_s) { rack->serve(start_ns + static_cast<std::int64_t>(time_s * 1e9)); }
  // The host takes a device and lets it sample.
  void take(std::size_t index, const net::UdpSocket& host) { take(index, host, host.local().port); }
  void take(std::size_t index, const net::UdpSocket& host, std::uint16_t imu_port) {
    std::vector<DeviceFrame> frames;
    VirtualLivox& device = rack->device(index);
    const std::uint16_t port = host.local().port;
    device.receive(start_ns, host.local(), livox::make_handshake({host.local().ip, port, port, imu_port}, 1), frames);
    device.receive(start_ns, host.local(), livox::encode_control(livox::SamplingRequest{livox::Sampling::start}, 2),
                   frames);
  }

  std::unique_ptr<VirtualRack> rack;
  std::int64_t start_ns = 0;
};

TEST_F(Rack, LetsIncidentsHappenAtTheirTime) {
  open({"left,1,clock,-2.5", "left,2,clock,4", "right,1,silence,2", "right,4,status,0x40000001", "left,3,reboot",
        "left,6,refuse,coordinates"});
  at(0.5);
  EXPECT_EQ(rack->clock_shift_ns(0), 0);
  at(1.1);
  EXPECT_EQ(rack->clock_shift_ns(0), -5 * second_ns / 2);
  EXPECT_TRUE(rack->device(1).is_silent(start_ns + 11 * second_ns / 10));
  at(2.5);
  EXPECT_EQ(rack->clock_shift_ns(0), 3 * second_ns / 2);
  at(3.1);
  EXPECT_EQ(rack->clock_shift_ns(0), 0);  // It has started anew.
  EXPECT_FALSE(rack->device(1).is_silent(start_ns + 31 * second_ns / 10));
  EXPECT_EQ(rack->device(1).status(), 0U);
  at(4.1);
  EXPECT_EQ(rack->device(1).status(), 0x40000001U);
  at(6.1);
  std::vector<DeviceFrame> frames;
  const Endpoint host{{127, 0, 0, 1}, 55501};
  rack->device(0).receive(start_ns + 7 * second_ns, host, livox::make_handshake({host.ip, 1, 55501, {}}, 1), frames);
  frames.clear();
  rack->device(0).receive(start_ns + 7 * second_ns, host,
                          livox::encode_control(livox::CoordinatesRequest{livox::Coordinates::spherical}, 2), frames);
  ASSERT_EQ(frames.size(), 1U);
  EXPECT_EQ(livox::parse_control_frame(frames[0].bytes)->payload[0], 1);
}

TEST_F(Rack, AnotherHostHasADeviceForAWhile) {
  open({"left,1,taken,2"});
  const auto broadcasts = [this](double time_s) {
    VirtualLivox& device = rack->device(0);
    std::vector<DeviceFrame> frames;
    device.tick(start_ns + static_cast<std::int64_t>(time_s * 1e9), frames);
    return frames.size();
  };
  at(1.1);
  EXPECT_EQ(broadcasts(2.9), 0U);
  at(3.1);
  EXPECT_EQ(broadcasts(5.0), 1U);
}

TEST_F(Rack, SendsToTheOwnerOnlyWhatADeviceWouldSend) {
  open({});
  auto host = net::UdpSocket::open({{{127, 7, 31, 100}, 0}, false, false, 0, {}});
  ASSERT_TRUE(host.has_value());
  const std::vector<std::uint8_t> packet(1318, 5);
  at(0.0);
  EXPECT_FALSE(rack->send(0, start_ns, false, packet));
  take(0, *host);
  EXPECT_TRUE(rack->is_any_sampling());
  EXPECT_FALSE(rack->are_all_sampling());
  EXPECT_TRUE(rack->send(0, start_ns, false, packet));
  EXPECT_TRUE(rack->send(0, start_ns, true, packet));
  EXPECT_FALSE(rack->send(1, start_ns, false, packet));
  rack->device(0).fall_silent(start_ns + second_ns);
  EXPECT_FALSE(rack->send(0, start_ns, false, packet));
  EXPECT_EQ(rack->counts().packets, 2U);
  EXPECT_EQ(rack->counts().bytes, 2U * 1318U);
  EXPECT_EQ(rack->faults(0).sent, 2U);
  net::ReceiveBatch batch(8);
  ASSERT_EQ(*host->receive(batch), 2U);
  EXPECT_EQ(batch[0].from, (Endpoint{{127, 7, 31, 1}, livox::kPointSourcePort}));
  EXPECT_EQ(batch[1].from, (Endpoint{{127, 7, 31, 1}, livox::kImuSourcePort}));
}

TEST_F(Rack, GoesOnWhereTheSystemRefusesToSend) {
  open({});
  auto host = net::UdpSocket::open({{{127, 7, 31, 100}, 0}, false, false, 0, {}});
  ASSERT_TRUE(host.has_value());
  at(0.0);
  take(0, *host, 0);
  ASSERT_TRUE(rack->is_any_sampling());
  const std::vector<std::uint8_t> packet(1318, 5);
  EXPECT_TRUE(rack->send(0, start_ns, true, packet));  // To port 0, which is no port.
  EXPECT_TRUE(rack->send(0, start_ns, false, packet));
  rack->flush();
  EXPECT_EQ(rack->counts().packets, 2U);
  EXPECT_EQ(rack->counts().unsent, 1U);
  net::ReceiveBatch batch(8);
  EXPECT_EQ(*host->receive(batch), 1U);
}

TEST_F(Rack, RefusesAddressesThatAreNotThereAndIncidentsOfNobody) {
  RackDevice away = device_at(1, "away");
  away.point_source.ip = {203, 0, 113, 7};
  EXPECT_FALSE(VirtualRack::open({away}, {}).has_value());
  RackOptions options;
  options.incidents.push_back(*parse_incident("nobody,1,reboot"));
  const auto refused = VirtualRack::open({device_at(1, "left")}, options);
  ASSERT_FALSE(refused.has_value());
  EXPECT_NE(refused.error().what.find("no LiDAR 'nobody'"), std::string::npos);
}

}  // namespace
}  // namespace rigcal::sim
