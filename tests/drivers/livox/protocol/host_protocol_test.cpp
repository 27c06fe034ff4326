// Several devices and hosts.
#include "drivers/livox/protocol/host_protocol.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace rigcal::livox {
namespace {

using testing::HasSubstr;
using testing::SizeIs;

constexpr std::int64_t second = 1'000'000'000;

HostAddress host(Ipv4 ip) { return {ip, {255, 255, 255, 0}, 55501, 56001, 56001}; }

WantedDevice wanted(const std::string& code) {
  WantedDevice device;
  device.broadcast_code = code;
  return device;
}

Broadcast mid40(const std::string& code) { return {code, DeviceType::mid40, 0}; }

template <class T>
std::vector<Event> told(const ProtocolOutput& out) {
  std::vector<Event> found;
  for (const Event& event : out.events)
    if (std::holds_alternative<T>(event.content)) found.push_back(event);
  return found;
}

class TwoHosts : public testing::Test {
 protected:
  static HostProtocol make() {
    WantedDevice by_address;
    by_address.ip = Ipv4{192, 168, 2, 40};
    auto made = HostProtocol::create(
        {host({192, 168, 1, 5}), host({192, 168, 2, 5})},
        {wanted("0TFDG3B00600551"), wanted("0TFDG3B00600552"), wanted("0TFDG3B00600553"), by_address});
    EXPECT_TRUE(made.has_value());
    return *std::move(made);
  }
  void hear(const Broadcast& broadcast, Ipv4 ip, std::size_t at = 0) {
    protocol.receive(now, at, {ip, kDevicePort}, make_broadcast(broadcast, 1), out);
  }
  // Answers all handshakes that were sent and forgets them.
  void take_all() {
    const auto frames = out.frames;
    out.frames.clear();
    for (const OutgoingFrame& sent : frames) {
      const auto frame = parse_control_frame(sent.bytes);
      if (command_of(*frame) == Command::handshake)
        protocol.receive(now, sent.host, sent.to, encode_control(HandshakeAck{}, frame->seq), out);
    }
  }

  HostProtocol protocol = make();
  ProtocolOutput out;
  std::int64_t now = 5 * second;
};

TEST_F(TwoHosts, TakeTheThreeUnitsOfAMid100AsThreeDevices) {
  hear(mid40("0TFDG3B00600551"), {192, 168, 1, 21});
  hear(mid40("0TFDG3B00600552"), {192, 168, 1, 91});
  hear(mid40("0TFDG3B00600553"), {192, 168, 1, 161});
  take_all();
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(protocol.device(i).state, LinkState::identifying) << i;
  EXPECT_EQ(protocol.device(1).ip, (Ipv4{192, 168, 1, 91}));
  // One goes silent, the others stay.
  for (int i = 0; i < 40; ++i) {
    now += second / 10;
    out.clear();
    protocol.tick(now, out);
    const auto frames = out.frames;
    for (const OutgoingFrame& sent : frames) {
      const auto frame = parse_control_frame(sent.bytes);
      if (command_of(*frame) == Command::heartbeat && sent.to.ip[3] != 91)
        protocol.receive(now, 0, sent.to, encode_control(HeartbeatAck{}, frame->seq), out);
    }
  }
  EXPECT_EQ(protocol.device(0).state, LinkState::identifying);
  EXPECT_EQ(protocol.device(1).state, LinkState::waiting);
  EXPECT_EQ(protocol.device(2).state, LinkState::identifying);
}

TEST_F(TwoHosts, TellADeviceTheAddressOfTheInterfaceThatHearsIt) {
  hear({"3JEDK380010Z391", DeviceType::avia, 0}, {192, 168, 2, 40}, 1);
  ASSERT_THAT(out.frames, SizeIs(1));
  EXPECT_EQ(out.frames[0].host, 1U);
  EXPECT_EQ(parse_handshake(*parse_control_frame(out.frames[0].bytes))->host_ip, (Ipv4{192, 168, 2, 5}));
  EXPECT_EQ(protocol.device(3).broadcast.broadcast_code, "3JEDK380010Z391");
}

TEST_F(TwoHosts, TellOfDevicesInAnotherSubnetAndDoNotTakeThem) {
  hear(mid40("0TFDG3B00600551"), {192, 168, 7, 21});
  hear(mid40("0TFDG3B00600551"), {192, 168, 7, 21});
  EXPECT_THAT(told<Unreachable>(out), SizeIs(1));
  EXPECT_TRUE(out.frames.empty());
  EXPECT_EQ(protocol.device(0).state, LinkState::waiting);
}

TEST_F(TwoHosts, TellOnceOfADeviceThatIsHeardWhereNobodyListens) {
  const Endpoint from{{192, 168, 9, 21}, kDevicePort};
  const std::vector<std::uint8_t> bytes = make_broadcast(mid40("0TFDG3B00600552"), 1);
  for (int i = 0; i < 3; ++i) protocol.receive_elsewhere(now, "eth3", from, bytes, out);
  protocol.receive_elsewhere(now, "eth3", from, make_broadcast(mid40("0TFDOTHER600551"), 1), out);
  protocol.receive_elsewhere(now, "eth3", from, ByteView{}, out);
  const auto elsewhere = told<HeardElsewhere>(out);
  ASSERT_THAT(elsewhere, SizeIs(1));
  EXPECT_EQ(elsewhere[0].device, 1U);
  EXPECT_THAT(event_text(elsewhere[0].content), HasSubstr("0TFDG3B00600552 at 192.168.9.21 is heard on eth3"));
  EXPECT_TRUE(out.frames.empty());
  EXPECT_EQ(protocol.device(1).state, LinkState::waiting);
}

TEST_F(TwoHosts, TellOfTwoDevicesWithOneAddress) {
  hear(mid40("0TFDG3B00600551"), {192, 168, 1, 21});
  take_all();
  hear(mid40("0TFDG3B00600552"), {192, 168, 1, 21});
  hear(mid40("0TFDG3B00600552"), {192, 168, 1, 21});
  const auto conflicts = told<AddressConflict>(out);
  ASSERT_THAT(conflicts, SizeIs(1));
  EXPECT_EQ(conflicts[0].device, 0U);
  EXPECT_EQ(protocol.device(1).state, LinkState::waiting);
  EXPECT_EQ(protocol.device(0).state, LinkState::identifying);
}

TEST_F(TwoHosts, ListForeignDevicesAndHubsAndLeaveThemAlone) {
  hear(mid40("0TFDOTHER600551"), {192, 168, 1, 22});
  hear({"13UUG3B00600551", DeviceType::hub, 0}, {192, 168, 2, 40}, 1);
  EXPECT_TRUE(out.frames.empty());
  ASSERT_THAT(protocol.sightings(), SizeIs(2));
  EXPECT_EQ(protocol.sightings()[0].device, kNoDevice);
  EXPECT_EQ(protocol.sightings()[1].broadcast.type, DeviceType::hub);
  EXPECT_EQ(told<Seen>(out)[0].device, kNoDevice);
}

TEST_F(TwoHosts, KeepABoundedListOfSightings) {
  for (int i = 0; i < 500; ++i) {
    now += second;
    const std::string number = std::to_string(1000 + i);
    hear(mid40("0TFDOTHER00" + number), {192, 168, 1, 22});
  }
  EXPECT_THAT(protocol.sightings(), SizeIs(kMaxSightings));
  EXPECT_EQ(std::count_if(protocol.sightings().begin(), protocol.sightings().end(),
                          [&](const Sighting& s) { return s.last_ns > now - 64 * second; }),
            64);
}

TEST(HostProtocol, RefusesListsThatMakeNoSense) {
  const auto message = [](std::vector<HostAddress> hosts, std::vector<WantedDevice> devices) {
    const auto made = HostProtocol::create(std::move(hosts), std::move(devices));
    return made ? std::string() : made.error().message();
  };
  const HostAddress here = host({192, 168, 1, 5});
  EXPECT_THAT(message({}, {wanted("0TFDG3B00600551")}), HasSubstr("0 addresses"));
  EXPECT_THAT(message({here}, {}), HasSubstr("0 devices"));
  EXPECT_THAT(message({here}, {wanted("0TFDG3B00600551"), wanted("0TFDG3B00600551")}), HasSubstr("named twice"));
  EXPECT_THAT(message({here}, {WantedDevice{}}), HasSubstr("neither a broadcast code nor an address"));
  EXPECT_THAT(message({here}, std::vector<WantedDevice>(40)), HasSubstr("40 devices"));
}

}  // namespace
}  // namespace rigcal::livox
