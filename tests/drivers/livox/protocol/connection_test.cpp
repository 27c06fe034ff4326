// Finding, taking, keeping, losing and freeing a device.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/livox/protocol/desk.h"

namespace rigcal::livox {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

TEST(Connection, GoesFromABroadcastToPoints) {
  Desk desk;
  desk.hear_broadcast();
  ASSERT_THAT(desk.told<Seen>(), SizeIs(1));
  ASSERT_THAT(desk.out.frames, SizeIs(1));
  EXPECT_EQ(desk.out.frames[0].to, desk.device);
  const auto handshake = parse_handshake(*desk.sent(Command::handshake));
  ASSERT_TRUE(handshake.has_value());
  EXPECT_EQ(*handshake, (Handshake{{192, 168, 1, 5}, 56001, 55501, std::uint16_t{56001}}));
  desk.answer(HandshakeAck{});
  EXPECT_EQ(desk.count_sent(Command::heartbeat), 1U);
  EXPECT_EQ(desk.count_sent(Command::device_information), 1U);
  desk.answer(DeviceInformationAck{ReturnCode::success, {11, 9, 0, 0}});
  ASSERT_THAT(desk.told<Connected>(), SizeIs(1));
  EXPECT_EQ(desk.told<Connected>()[0].firmware, (FirmwareVersion{11, 9, 0, 0}));
  desk.beat(WorkState::initialising, 40);
  EXPECT_EQ(desk.info().progress_percent, 40U);
  EXPECT_EQ(desk.info().status, 0U);
  EXPECT_EQ(desk.count_sent(Command::coordinates), 0U);
  desk.pass(800);
  desk.beat(WorkState::normal, 0x2000);
  EXPECT_EQ(desk.info().status, 0x2000U);
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
  ASSERT_THAT(desk.told<SamplingChanged>(), SizeIs(1));
  EXPECT_TRUE(desk.told<SamplingChanged>()[0].on);
}

TEST(Connection, SendsTheFormOfTheHandshakeThatTheModelKnowsAndTheOtherNext) {
  Desk desk({"0TFDG3B00600551", {}, {}, true, PowerMode::normal}, {"0TFDG3B00600551", DeviceType::mid40, 0});
  std::vector<std::size_t> sizes;
  std::vector<FrameType> types;
  for (int i = 0; i < 3; ++i) {
    desk.hear_broadcast();
    const auto frame = desk.sent(Command::handshake);
    ASSERT_TRUE(frame.has_value());
    sizes.push_back(frame->payload.size());
    types.push_back(frame->type);
    desk.pass(1000);
  }
  EXPECT_THAT(sizes, ElementsAre(8U, 10U, 8U));
  EXPECT_THAT(types, ElementsAre(FrameType::command, FrameType::ack, FrameType::command));
  EXPECT_THAT(desk.told<HandshakeUnanswered>(), SizeIs(3));
}

TEST(Connection, TheFormOfTheHandshakeThatWasTakenComesFirstTheNextTime) {
  Desk desk;
  const auto next_size = [&desk] {
    desk.hear_broadcast();
    return desk.sent(Command::handshake)->payload.size();
  };
  EXPECT_EQ(next_size(), 10U);
  desk.answer(HandshakeAck{});
  desk.pass(3100);
  ASSERT_EQ(desk.state(), LinkState::waiting);
  EXPECT_EQ(next_size(), 10U);
  desk.answer(HandshakeAck{ReturnCode::failure});
  desk.pass(1000);
  EXPECT_EQ(next_size(), 8U);
  desk.answer(HandshakeAck{});
  desk.pass(3100);
  ASSERT_EQ(desk.state(), LinkState::waiting);
  EXPECT_EQ(next_size(), 8U);
}

TEST(Connection, ASecondHostThatOwnsTheDeviceIsToldAndWaitedFor) {
  Desk desk;
  desk.hear_broadcast();
  desk.answer(HandshakeAck{ReturnCode::failure});
  EXPECT_THAT(desk.told<HandshakeRefused>(), SizeIs(1));
  desk.hear_broadcast();  // At once: not asked again, a storm of broadcasts is none of handshakes.
  EXPECT_EQ(desk.count_sent(Command::handshake), 1U);
  desk.pass(1000);
  desk.hear_broadcast();
  desk.answer(HandshakeAck{});
  EXPECT_EQ(desk.state(), LinkState::identifying);
}

TEST(Connection, HeartbeatsComeInTimeAndTheirLastAckCounts) {
  Desk desk;
  desk.sample();
  desk.pass_alive(8000);
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_NEAR(static_cast<double>(desk.count_sent(Command::heartbeat)), 11.0, 1.0);
  desk.pass(2800);
  EXPECT_EQ(desk.state(), LinkState::sampling);
  desk.beat();
  desk.pass(2800);
  EXPECT_EQ(desk.state(), LinkState::sampling);
  desk.pass(250);
  EXPECT_EQ(desk.state(), LinkState::waiting);
  ASSERT_THAT(desk.told<Lost>(), SizeIs(1));
  EXPECT_EQ(desk.told<Lost>()[0].cause, LossCause::silence);
  EXPECT_FALSE(desk.told<SamplingChanged>().back().on);
}

TEST(Connection, AnOldOrRepeatedHeartbeatAckIsNoSignOfLife) {
  Desk desk;
  desk.sample();
  desk.pass(800);
  const auto old = desk.sent(Command::heartbeat)->seq;
  desk.beat();
  for (int i = 0; i < 3; ++i) {
    desk.pass(1000);
    desk.hear(encode_control(HeartbeatAck{ReturnCode::success, WorkState::normal, 0, 0}, old));
  }
  EXPECT_EQ(desk.state(), LinkState::waiting);
}

TEST(Connection, RefusedHeartbeatsLoseTheDevice) {
  Desk desk;
  desk.sample();
  for (int i = 0; i < 4; ++i) {
    desk.pass(800);
    desk.beat(WorkState::normal, 0, ReturnCode::failure);
  }
  EXPECT_EQ(desk.state(), LinkState::waiting);
  EXPECT_GE(desk.info().counters.refused_heartbeats, 3U);
}

TEST(Connection, ALostDeviceIsTakenAgainAndSetUpAgain) {
  Desk desk;
  desk.sample();
  desk.pass(3100);
  desk.out.clear();
  desk.sample();
  EXPECT_EQ(desk.info().counters.losses, 1U);
  EXPECT_EQ(desk.count_sent(Command::coordinates), 1U);
}

TEST(Connection, ADeviceThatRestartedIsTakenAtItsFirstBroadcast) {
  Desk desk;
  desk.sample();
  desk.pass_alive(2000);
  desk.out.clear();
  desk.pass(1300);
  desk.hear_broadcast();
  ASSERT_THAT(desk.told<Lost>(), SizeIs(1));
  EXPECT_EQ(desk.told<Lost>()[0].cause, LossCause::let_go);
  EXPECT_EQ(desk.state(), LinkState::handshaking);
}

TEST(Connection, ALateBroadcastOfALivingDeviceChangesNothing) {
  Desk desk;
  desk.sample();
  desk.pass_alive(2000);
  desk.out.clear();
  desk.hear_broadcast();
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_TRUE(desk.out.frames.empty());
}

TEST(Connection, ADeviceMayComeBackWithAnotherAddress) {
  Desk desk;
  desk.sample();
  desk.pass(3100);
  desk.device.ip = {192, 168, 1, 77};
  desk.sample();
  EXPECT_EQ(desk.info().ip, (Ipv4{192, 168, 1, 77}));
  EXPECT_EQ(desk.out.frames.back().to.ip, (Ipv4{192, 168, 1, 77}));
  EXPECT_THAT(desk.told<Seen>(), SizeIs(2));
}

TEST(Connection, CommandsGoToTheControlPortWhateverTheBroadcastCameFrom) {
  Desk desk;
  desk.device.port = 40000;
  desk.hear_broadcast();
  EXPECT_EQ(desk.out.frames[0].to.port, 40000);
  desk.answer(HandshakeAck{});
  EXPECT_EQ(desk.out.frames.back().to, (Endpoint{{192, 168, 1, 139}, kDevicePort}));
}

TEST(Connection, ADeviceThatSpinsDownAndUpIsSetUpAgain) {
  Desk desk;
  desk.sample();
  desk.pass(800);
  desk.beat(WorkState::initialising, 10);
  EXPECT_EQ(desk.state(), LinkState::preparing);
  EXPECT_FALSE(desk.told<SamplingChanged>().back().on);
  desk.out.clear();
  desk.pass(800);
  desk.beat();
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(Connection, CountsHowOftenSamplingEndedUnasked) {
  Desk desk;
  desk.sample();
  desk.pass(800);
  desk.beat(WorkState::standby);  // It is too hot, or somebody else has told it to.
  EXPECT_EQ(desk.info().counters.interruptions, 1U);
  EXPECT_EQ(desk.info().counters.losses, 0U);
  desk.pass(800);
  desk.beat(WorkState::standby);
  EXPECT_EQ(desk.info().counters.interruptions, 1U);
  desk.pass(800);
  desk.beat();
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{});
  ASSERT_EQ(desk.state(), LinkState::sampling);
  desk.pass(3100);
  EXPECT_EQ(desk.info().counters.interruptions, 2U);
  EXPECT_EQ(desk.info().counters.losses, 1U);
}

TEST(Connection, WhatWasAskedForIsNoInterruption) {
  const auto interruptions_after = [](const auto& act) {
    Desk desk;
    desk.sample();
    act(desk);
    EXPECT_NE(desk.state(), LinkState::sampling);
    return desk.info().counters.interruptions;
  };
  EXPECT_EQ(interruptions_after([](Desk& desk) { desk.protocol.leave(desk.now_ns, desk.out); }), 0U);
  EXPECT_EQ(
      interruptions_after([](Desk& desk) { desk.protocol.set_power(desk.now_ns, 0, PowerMode::standby, desk.out); }),
      0U);
  EXPECT_EQ(interruptions_after([](Desk& desk) {
              desk.protocol.set_sampling(desk.now_ns, 0, false, desk.out);
              desk.answer(SamplingAck{});
            }),
            0U);
  EXPECT_EQ(interruptions_after([](Desk& desk) {
              ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, RebootRequest{100}, desk.out).has_value());
              desk.answer(RebootAck{});
            }),
            0U);
}

TEST(Connection, LeavingStopsAndFreesTheDevice) {
  Desk desk;
  desk.sample();
  desk.out.clear();
  desk.protocol.leave(desk.now_ns, desk.out);
  const auto stop = decode_control(*desk.sent(Command::sampling));
  ASSERT_TRUE(stop.has_value());
  EXPECT_EQ(std::get<SamplingRequest>(*stop).value, Sampling::stop);
  desk.answer(SamplingAck{});
  desk.answer(DisconnectAck{});
  EXPECT_EQ(desk.state(), LinkState::closed);
  EXPECT_TRUE(desk.protocol.is_closed());
  EXPECT_FALSE(desk.protocol.deadline_ns().has_value());
}

TEST(Connection, LeavingADeviceThatIsSilentTakesASecond) {
  Desk desk;
  desk.sample();
  desk.protocol.leave(desk.now_ns, desk.out);
  desk.pass(950);
  EXPECT_EQ(desk.state(), LinkState::leaving);
  EXPECT_EQ(desk.count_sent(Command::disconnect), 1U);
  desk.pass(50);
  EXPECT_TRUE(desk.protocol.is_closed());
}

TEST(Connection, StatesAndEventsHaveNames) {
  for (int state = 0; state < 10; ++state) EXPECT_STRNE(to_string(static_cast<LinkState>(state)), "?");
  Desk desk;
  desk.sample();
  desk.pass(3100);
  for (const Event& event : desk.out.events) EXPECT_FALSE(event_text(event.content).empty());
  EXPECT_EQ(event_text(desk.told<Connected>()[0]), "connected: Avia, firmware 11.09.00.00, at 192.168.1.139");
  EXPECT_EQ(event_text(StatusChanged{0, 0x40006840}), "status word 0x40006840 (was 0x00000000)");
}

}  // namespace
}  // namespace rigcal::livox
