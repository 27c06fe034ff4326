// Devices that behave in the odd ways that the protocol page tells of (sections 4, 11 and 14) and that are no plain
// event in a state (state_table_test.cpp).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/livox/protocol/desk.h"

namespace rigcal::livox {
namespace {

using testing::SizeIs;

// A frame as the device would make it, from its parts: some of these the codec does not write.
std::vector<std::uint8_t> ack_to(const ControlFrame& request, const std::vector<std::uint8_t>& payload) {
  return make_control_frame({FrameType::ack, request.seq, request.set, request.id, payload});
}

TEST(OddDevice, SaysAnythingInTheReservedFieldOfItsBroadcast) {
  for (const std::uint16_t reserved : {0, 1, 55000, 65000, 65535}) {
    Broadcast broadcast = avia_broadcast();
    broadcast.command_port = reserved;
    Desk desk(wanted_avia(), broadcast);
    desk.sample();
    EXPECT_EQ(desk.state(), LinkState::sampling) << reserved;
  }
}

TEST(OddDevice, AnswersFromAnotherPortThanItListensAt) {
  Desk desk;
  desk.hear_broadcast();
  desk.device.port = 40001;
  desk.answer(HandshakeAck{});
  EXPECT_EQ(desk.state(), LinkState::identifying);
  desk.device.port = 40002;
  desk.answer(DeviceInformationAck{ReturnCode::success, {11, 9, 0, 0}});
  desk.beat();
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_EQ(desk.out.frames.back().to.port, kDevicePort);
}

TEST(OddDevice, SendsAFrameOfNoLengthThatJamsTheVendorsParser) {
  Desk desk;
  std::vector<std::uint8_t> frame = make_broadcast(desk.broadcast, 1);
  frame.resize(9);
  frame[2] = frame[3] = 0;
  const std::uint16_t sum = crc16(ByteView(frame).first(7));
  frame[7] = static_cast<std::uint8_t>(sum);
  frame[8] = static_cast<std::uint8_t>(sum >> 8U);
  for (int i = 0; i < 100; ++i) desk.hear(frame);
  EXPECT_EQ(desk.protocol.counters().malformed, 100U);
  desk.sample();
  desk.hear(frame);
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(OddDevice, ClaimsMoreBytesThanItSends) {
  Desk desk;
  const std::vector<std::uint8_t> whole = make_broadcast(desk.broadcast, 1);
  desk.hear(ByteView(whole).first(whole.size() - 1));
  EXPECT_EQ(desk.protocol.counters().malformed, 1U);
  EXPECT_TRUE(desk.out.frames.empty());  // Nothing is kept of it that would spoil what follows.
  desk.sample();
}

// Switches may pad datagrams: what comes after the frame is nobody's.
TEST(OddDevice, GluesTwoFramesTogether) {
  Desk desk;
  const std::vector<std::uint8_t> whole = make_broadcast(desk.broadcast, 1);
  std::vector<std::uint8_t> glued = whole;
  glued.insert(glued.end(), whole.begin(), whole.end());
  desk.hear(glued);
  EXPECT_EQ(desk.protocol.counters().malformed, 0U);
  EXPECT_EQ(desk.out.frames.size(), 1U);  // The handshake.
  desk.sample();
}

TEST(OddDevice, RefusesInOneByteWhateverTheAnswerShouldBe) {
  WantedDevice wanted = wanted_avia();
  wanted.settings.repetitive_scan = Switch::on;
  Desk desk(wanted);
  desk.identify();
  desk.beat();
  desk.answer(CoordinatesAck{});
  desk.hear(ack_to(*desk.asked(), {1}));
  EXPECT_EQ(desk.outcome(Command::write_parameters), Outcome::refused);
  EXPECT_EQ(desk.count_sent(Command::write_parameters), 1U);
  desk.answer(SamplingAck{});
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, GetIpModeRequest{}, desk.out));
  desk.hear(ack_to(*desk.asked(), {1}));
  EXPECT_EQ(desk.outcome(Command::get_ip_mode), Outcome::refused);
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(OddDevice, IsAMid40AndTellsItsAddressInSixBytes) {
  Desk desk({"0TFDG3B00600551", {}, {}, true, PowerMode::normal}, {"0TFDG3B00600551", DeviceType::mid40, 0});
  desk.identify({3, 8, 0, 0});
  desk.beat();
  desk.answer(SamplingAck{});
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, GetIpModeRequest{}, desk.out));
  desk.hear(ack_to(*desk.asked(), {0, 1, 192, 168, 1, 21}));
  const auto ended = desk.told<RequestEnded>();
  ASSERT_FALSE(ended.empty());
  const auto* answer = std::get_if<GetIpModeAck>(&ended.back().answer);
  ASSERT_NE(answer, nullptr);
  EXPECT_EQ(answer->ip, (Ipv4{192, 168, 1, 21}));
  EXPECT_FALSE(answer->subnet.has_value());
}

TEST(OddDevice, CountsUpWhileItStartsInPlaceOfItsStatus) {
  Desk desk;
  desk.identify();
  for (const std::uint32_t percent : {0U, 40U, 100U, 4000000000U}) {
    desk.pass(800);
    desk.beat(WorkState::initialising, percent);
    EXPECT_EQ(desk.info().progress_percent, percent);
    EXPECT_EQ(desk.info().status, 0U);
  }
  EXPECT_THAT(desk.told<StatusChanged>(), SizeIs(0));
}

TEST(OddDevice, SaysTenTimesASecondThatSomethingIsWrong) {
  Desk desk;
  desk.sample();
  for (int i = 0; i < 100; ++i) {
    desk.hear(encode_control(AbnormalStatus{0x40006840}, static_cast<std::uint16_t>(i)));
    desk.pass(100);
    desk.beat(WorkState::normal, 0x40006840);
  }
  EXPECT_THAT(desk.told<StatusChanged>(), SizeIs(1));
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(OddDevice, StartsOnlyWhenItIsReadyWhateverItSaid) {
  // It says that it is in order and refuses to start for a while, as when its motor is still on the way.
  Desk desk;
  desk.identify();
  desk.beat();
  desk.answer(CoordinatesAck{});
  for (int i = 0; i < 5; ++i) {
    desk.answer(SamplingAck{ReturnCode::failure});
    EXPECT_EQ(desk.state(), LinkState::idle);
    desk.pass_alive(1100);
  }
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_THAT(desk.told<Lost>(), SizeIs(0));
}

TEST(OddDevice, TakesSecondsFromOneBroadcastToTheNext) {
  Desk desk;
  desk.hear_broadcast();
  desk.pass(3020);  // As a Mid-70 was seen to.
  EXPECT_EQ(desk.state(), LinkState::waiting);
  desk.sample();
}

TEST(OddDevice, SendsBroadcastsInAStorm) {
  Desk desk;
  for (int i = 0; i < 1000; ++i) desk.hear_broadcast();
  EXPECT_EQ(desk.count_sent(Command::handshake), 1U);
  desk.answer(HandshakeAck{});
  for (int i = 0; i < 1000; ++i) desk.hear_broadcast();
  EXPECT_EQ(desk.state(), LinkState::identifying);
  EXPECT_EQ(desk.count_sent(Command::handshake), 1U);
}

}  // namespace
}  // namespace rigcal::livox
