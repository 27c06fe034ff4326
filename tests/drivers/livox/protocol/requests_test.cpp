// Settings, sampling, power modes and requests of the user.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/drivers/livox/protocol/desk.h"

namespace rigcal::livox {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<Command> commands_of(const Desk& desk) {
  std::vector<Command> commands;
  for (const OutgoingFrame& outgoing : desk.out.frames) {
    const Command command = command_of(*parse_control_frame(outgoing.bytes));
    if (command != Command::heartbeat) commands.push_back(command);
  }
  return commands;
}

std::vector<std::string> missing(const Desk& desk) {
  std::vector<std::string> settings;
  for (const MissingSetting& setting : desk.info().missing_settings) settings.push_back(setting.setting);
  return settings;
}

void answer_with_success(Desk& desk) {
  const auto asked = desk.asked();
  ASSERT_TRUE(asked.has_value());
  const bool parameters = command_of(*asked) == Command::write_parameters;
  const std::vector<std::uint8_t> payload(parameters ? 4 : 1, 0);
  desk.hear(make_control_frame({FrameType::ack, asked->seq, asked->set, asked->id, payload}));
}

TEST(Setup, SendsEverySettingInTheOrderThatDevicesWant) {
  WantedDevice wanted = wanted_avia();
  wanted.settings = {Coordinates::spherical,
                     Echoes::dual,
                     ImuRate::hz_200,
                     Switch::on,
                     Switch::on,
                     {},
                     {},
                     StoredExtrinsics{1.0F, 2.0F, 3.0F, 4, 5, 6}};
  Desk desk(wanted);
  desk.identify();
  desk.beat();
  desk.out.frames.clear();
  desk.beat();
  desk.pass(500);
  while (desk.state() == LinkState::configuring) answer_with_success(desk);
  EXPECT_THAT(commands_of(desk), ElementsAre(Command::coordinates, Command::set_return_mode, Command::set_imu_rate,
                                             Command::write_parameters, Command::write_parameters,
                                             Command::write_extrinsics, Command::sampling));
}

TEST(Setup, DoesNotAskForWhatTheModelOrItsFirmwareCannotDo) {
  WantedDevice wanted{"0TFDG3B00600551", {}, {}, true, PowerMode::normal};
  wanted.settings.return_mode = Echoes::dual;
  wanted.settings.imu_rate = ImuRate::hz_200;
  wanted.settings.fan = Switch::on;
  wanted.settings.rain_suppression = Switch::on;
  Desk desk(wanted, {"0TFDG3B00600551", DeviceType::mid40, 0});
  desk.identify({3, 6, 0, 0});
  std::vector<Command> unsupported;
  for (const RequestEnded& ended : desk.told<RequestEnded>()) {
    EXPECT_EQ(ended.outcome, Outcome::unsupported);
    unsupported.push_back(ended.command);
  }
  EXPECT_THAT(unsupported, ElementsAre(Command::set_return_mode, Command::set_imu_rate, Command::set_fan));
  EXPECT_THAT(missing(desk), ElementsAre("return_mode: dual", "imu: true", "fan: on"));
  desk.beat();
  answer_with_success(desk);
  answer_with_success(desk);
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(Setup, ARefusedOrUnansweredSettingIsToldAndTheRestGoesOn) {
  WantedDevice wanted = wanted_avia();
  wanted.settings.return_mode = Echoes::triple;
  Desk desk(wanted);
  desk.identify();
  desk.beat();
  desk.answer(CoordinatesAck{ReturnCode::failure});
  EXPECT_EQ(desk.outcome(Command::coordinates), Outcome::refused);
  EXPECT_THAT(missing(desk), ElementsAre("coordinates: cartesian"));
  for (int i = 0; i < 16; ++i) {
    desk.pass(100);
    desk.beat();
  }
  EXPECT_EQ(desk.outcome(Command::set_return_mode), Outcome::unanswered);
  EXPECT_EQ(desk.count_sent(Command::set_return_mode), 3U);
  EXPECT_EQ(desk.info().counters.repeated, 2U);
  EXPECT_THAT(missing(desk), ElementsAre("coordinates: cartesian", "return_mode: triple"));
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(Setup, WhatADeviceMeetsThatDoesNotKnowItIsNotMissing) {
  WantedDevice wanted{"0TFDG3B00600551", {}, {}, true, PowerMode::normal};
  wanted.settings.return_mode = Echoes::strongest;
  wanted.settings.imu_rate = ImuRate::off;
  wanted.settings.repetitive_scan = Switch::off;
  Desk desk(wanted, {"0TFDG3B00600551", DeviceType::mid40, 0});
  desk.identify({3, 6, 0, 0});
  EXPECT_THAT(desk.told<RequestEnded>(), SizeIs(3));
  for (const RequestEnded& ended : desk.told<RequestEnded>()) EXPECT_EQ(ended.setting, "");
  EXPECT_THAT(missing(desk), IsEmpty());
}

TEST(Setup, AnUnansweredSettingIsAskedForAgainEachSecondUntilItIsTaken) {
  WantedDevice wanted = wanted_avia();
  wanted.settings.imu_rate = ImuRate::hz_200;
  Desk desk(wanted);
  desk.identify();
  desk.beat();
  desk.pass_alive(1600);  // Neither coordinates
  desk.pass_alive(1600);  // nor IMU.
  desk.answer(SamplingAck{});
  ASSERT_EQ(desk.state(), LinkState::sampling);
  EXPECT_THAT(missing(desk), ElementsAre("coordinates: cartesian", "imu: true"));
  desk.pass_alive(20'000);
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_GT(desk.count_sent(Command::coordinates), 12U);
  EXPECT_GT(desk.count_sent(Command::set_imu_rate), 12U);  // The first one keeps it from nothing.
  EXPECT_THAT(desk.told<RequestEnded>(), SizeIs(3));       // And it is told once of each.
  desk.out.clear();
  while (!desk.sent(Command::set_imu_rate)) desk.pass_alive(100);
  desk.answer(SetImuRateAck{});
  ASSERT_EQ(desk.outcome(Command::set_imu_rate), Outcome::done);
  EXPECT_EQ(event_text(desk.told<RequestEnded>().back()), "`imu: true` is in force now");
  EXPECT_THAT(missing(desk), ElementsAre("coordinates: cartesian"));
  while (!desk.sent(Command::coordinates)) desk.pass_alive(100);
  desk.answer(CoordinatesAck{});
  EXPECT_THAT(missing(desk), IsEmpty());
  desk.out.clear();
  desk.pass_alive(5000);
  EXPECT_EQ(desk.count_sent(Command::coordinates) + desk.count_sent(Command::set_imu_rate), 0U);
}

TEST(Setup, ARefusedSettingIsNotAskedForAgainBeforeTheDeviceComesBack) {
  Desk desk;
  desk.identify();
  desk.beat();
  desk.answer(CoordinatesAck{ReturnCode::failure});
  desk.answer(SamplingAck{});
  desk.pass_alive(5000);
  EXPECT_EQ(desk.count_sent(Command::coordinates), 1U);
  EXPECT_THAT(missing(desk), ElementsAre("coordinates: cartesian"));
  desk.pass(3100);
  desk.out.clear();
  desk.sample();
  EXPECT_THAT(missing(desk), IsEmpty());
}

TEST(Setup, ASettingThatIsNotInForceIsNamedWithAMend) {
  const auto text = [](const ControlPayload& request, Outcome outcome) {
    return missing_text(setting_text(request), outcome) + ": " + mend_of_missing(outcome);
  };
  DeviceSettings all{
      Coordinates::spherical, Echoes::first, ImuRate::off, Switch::on, Switch::off, Switch::on, Switch::off,
      StoredExtrinsics{}};
  std::vector<std::string> names;
  for (const ControlPayload& request : setup_requests(all)) names.push_back(setting_text(request));
  EXPECT_THAT(names,
              ElementsAre("coordinates: spherical", "return_mode: first", "imu: false", "high_sensitivity: on",
                          "scan_pattern: non_repetitive", "fan: on", "rain_suppression: off", "stored extrinsics"));
  EXPECT_EQ(text(SetReturnModeRequest{Echoes::dual}, Outcome::unsupported),
            "`return_mode: dual` is not in force (not known to the model or its firmware): update its firmware, or "
            "change that in the rig file");
  EXPECT_THAT(text(SetImuRateRequest{ImuRate::hz_200}, Outcome::unanswered),
              HasSubstr("`imu: true` is not in force (not answered): it is asked again each second"));
  EXPECT_THAT(text(SetReturnModeRequest{Echoes::triple}, Outcome::refused), HasSubstr("restart the device"));
}

TEST(Setup, ParameterErrorsComeWithTheAnswer) {
  WantedDevice wanted = wanted_avia();
  wanted.settings = {};
  wanted.settings.repetitive_scan = Switch::on;
  Desk desk(wanted);
  desk.identify();
  desk.beat();
  WriteParametersAck refusal;
  refusal.ret = ReturnCode::failure;
  refusal.error_key = 2;
  refusal.error = ParameterError::key_not_supported;
  desk.answer(refusal);
  const auto ended = desk.told<RequestEnded>();
  ASSERT_THAT(ended, SizeIs(1));
  EXPECT_EQ(std::get<WriteParametersAck>(ended[0].answer).error, ParameterError::key_not_supported);
}

TEST(Repetition, KeepsTheNumberAndTakesALateAnswerOnce) {
  Desk desk;
  desk.identify();
  desk.beat();
  const auto first = desk.sent(Command::coordinates);
  desk.pass(500);
  const auto second = desk.sent(Command::coordinates);
  EXPECT_EQ(desk.count_sent(Command::coordinates), 2U);
  EXPECT_EQ(first->seq, second->seq);
  desk.answer(CoordinatesAck{});
  desk.answer(CoordinatesAck{});
  EXPECT_EQ(desk.info().counters.stray_acks, 1U);
  EXPECT_EQ(desk.count_sent(Command::sampling), 1U);
}

TEST(Repetition, AnUnreadableAnswerIsAskedForAgain) {
  Desk desk;
  desk.shake_hands();
  const auto request = desk.sent(Command::device_information);
  const std::vector<std::uint8_t> payload{0, 11};
  desk.hear(make_control_frame({FrameType::ack, request->seq, request->set, request->id, payload}));
  EXPECT_EQ(desk.info().counters.unreadable, 1U);
  desk.answer(DeviceInformationAck{ReturnCode::failure, {}});
  EXPECT_EQ(desk.state(), LinkState::identifying);
  desk.pass_alive(1000);
  EXPECT_EQ(desk.count_sent(Command::device_information), 3U);
  desk.answer(DeviceInformationAck{ReturnCode::success, {11, 9, 0, 0}});
  EXPECT_THAT(desk.told<Connected>(), SizeIs(1));
}

TEST(Sampling, ARefusedStartIsTriedAgainEverySecond) {
  Desk desk;
  desk.identify();
  desk.beat();
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{ReturnCode::failure});
  EXPECT_EQ(desk.state(), LinkState::idle);
  desk.pass_alive(900);
  EXPECT_EQ(desk.count_sent(Command::sampling), 1U);
  desk.pass_alive(300);
  EXPECT_EQ(desk.count_sent(Command::sampling), 2U);
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(Sampling, StopsAndStartsAsWanted) {
  Desk desk;
  desk.sample();
  desk.protocol.set_sampling(desk.now_ns, 0, false, desk.out);
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::idle);
  // Changed again while the request is open.
  desk.protocol.set_sampling(desk.now_ns, 0, true, desk.out);
  desk.protocol.set_sampling(desk.now_ns, 0, false, desk.out);
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::idle);
}

TEST(Power, ADeviceInStandbyIsWokenAndSwitchingIsWaitedFor) {
  Desk desk;
  desk.identify();
  desk.beat(WorkState::standby);
  EXPECT_EQ(desk.count_sent(Command::set_power_mode), 1U);
  desk.answer(SetPowerModeAck{ReturnCode::switching});
  EXPECT_EQ(desk.outcome(Command::set_power_mode), Outcome::switching);
  desk.pass_alive(2000, WorkState::standby);
  EXPECT_EQ(desk.count_sent(Command::set_power_mode), 1U);
  desk.pass_alive(2000, WorkState::initialising);
  EXPECT_EQ(desk.state(), LinkState::preparing);
  desk.pass_alive(900, WorkState::normal);
  EXPECT_EQ(desk.state(), LinkState::configuring);
}

TEST(Power, ARefusedModeIsAskedForAgainLater) {
  Desk desk;
  desk.identify();
  desk.beat(WorkState::power_saving);
  desk.answer(SetPowerModeAck{ReturnCode::failure});
  EXPECT_EQ(desk.outcome(Command::set_power_mode), Outcome::refused);
  desk.pass_alive(5200, WorkState::power_saving);
  EXPECT_EQ(desk.count_sent(Command::set_power_mode), 2U);
}

TEST(Power, StandbyAndBack) {
  Desk desk;
  desk.sample();
  desk.protocol.set_power(desk.now_ns, 0, PowerMode::standby, desk.out);
  EXPECT_EQ(desk.state(), LinkState::preparing);
  desk.answer(SetPowerModeAck{});
  desk.pass_alive(900, WorkState::standby);
  EXPECT_EQ(desk.state(), LinkState::resting);
  desk.protocol.set_power(desk.now_ns, 0, PowerMode::normal, desk.out);
  desk.answer(SetPowerModeAck{ReturnCode::switching});
  desk.pass_alive(900);
  desk.answer(CoordinatesAck{});
  desk.answer(SamplingAck{});
  EXPECT_EQ(desk.state(), LinkState::sampling);
}

TEST(Requests, AreAskedOneByOneAndAnswered) {
  Desk desk;
  desk.sample();
  desk.out.clear();
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, GetIpModeRequest{}, desk.out));
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, ReadExtrinsicsRequest{}, desk.out));
  EXPECT_EQ(desk.count_sent(Command::read_extrinsics), 0U);
  desk.answer(GetIpModeAck{ReturnCode::success, IpMode::fixed, {192, 168, 1, 139}, Subnet{}});
  desk.answer(ReadExtrinsicsAck{ReturnCode::success, {1.0F, 2.0F, 3.0F, 4, 5, 6}});
  const auto ended = desk.told<RequestEnded>();
  ASSERT_THAT(ended, SizeIs(2));
  EXPECT_EQ(std::get<GetIpModeAck>(ended[0].answer).ip, (Ipv4{192, 168, 1, 139}));
  EXPECT_EQ(std::get<ReadExtrinsicsAck>(ended[1].answer).value.z_mm, 6);
}

TEST(Requests, AreBoundedAndAllEndWhenTheDeviceGoes) {
  Desk desk;
  desk.sample();
  desk.out.clear();
  std::size_t taken = 0;
  while (desk.protocol.request(desk.now_ns, 0, GetIpModeRequest{}, desk.out)) ++taken;
  EXPECT_EQ(taken, kMaxRequests + 1);  // One is on its way.
  desk.protocol.tick(desk.now_ns + 3000 * kMs, desk.out);
  EXPECT_THAT(desk.told<RequestEnded>(), SizeIs(taken));
  EXPECT_EQ(desk.outcome(Command::get_ip_mode), Outcome::lost);
}

TEST(Requests, RefuseWhatIsNoRequestOrWhatTheModelCannotDo) {
  Desk desk;
  desk.sample();
  const auto refusal = [&](const ControlPayload& payload) {
    const auto asked = desk.protocol.request(desk.now_ns, 0, payload, desk.out);
    return asked ? std::string() : asked.error().message();
  };
  EXPECT_THAT(refusal(SetFanRequest{Switch::on}), HasSubstr("the Avia with firmware 11.09.00.00 does not know this"));
  EXPECT_THAT(refusal(HeartbeatRequest{}), HasSubstr("cannot be asked by a user"));
  EXPECT_THAT(refusal(SamplingAck{}), HasSubstr("cannot be asked by a user"));
  EXPECT_THAT(refusal(RawControl{}), HasSubstr("cannot be asked by a user"));
  EXPECT_THAT(refusal(SetUtcTimeRequest{}), HasSubstr("fits into no frame"));
  EXPECT_THAT(refusal(ReadParametersRequest{std::vector<std::uint16_t>(256, 1)}), HasSubstr("fits into no frame"));
  EXPECT_THAT(refusal(WriteParametersRequest{{{1, std::vector<std::uint8_t>(1400, 0)}}}),
              HasSubstr("fits into no frame"));
  EXPECT_THAT(refusal(HubListLidarsRequest{}), HasSubstr("does not know this"));
  EXPECT_THAT(desk.protocol.request(desk.now_ns, 5, GetIpModeRequest{}, desk.out).error().message(),
              HasSubstr("there is no device 5"));
}

TEST(TimeOfDay, IsToldToDevicesWithPulsesOnlyAndItsAnswerCounted) {
  Desk desk;
  desk.sample();
  desk.out.clear();
  constexpr std::int64_t noon = 1'600'000'000'000 * kMs;
  desk.protocol.tell_utc(noon, desk.out);
  EXPECT_FALSE(desk.sent(Command::set_utc_time).has_value());  // No pulses.
  desk.hear(encode_control(AbnormalStatus{1U << 9U}, 1));
  desk.out.clear();
  desk.protocol.tell_utc(noon, desk.out);
  const auto first = desk.sent(Command::set_utc_time);
  ASSERT_TRUE(first.has_value());
  EXPECT_EQ(std::get<SetUtcTimeRequest>(*decode_control(*first)).value.unix_ns, noon);
  desk.answer(SetUtcTimeAck{});
  desk.answer(SetUtcTimeAck{});  // Once more: it answers nothing.
  desk.protocol.tell_utc(noon + 1000 * kMs, desk.out);
  desk.answer(SetUtcTimeAck{ReturnCode::failure});
  EXPECT_EQ(desk.info().counters.utc_taken, 1U);
  EXPECT_EQ(desk.info().counters.utc_refused, 1U);
  EXPECT_EQ(desk.info().counters.stray_acks, 1U);
  EXPECT_EQ(desk.state(), LinkState::sampling);
  EXPECT_TRUE(desk.told<RequestEnded>().empty());
  // A time that no frame can say is not sent.
  desk.out.clear();
  desk.protocol.tell_utc(0, desk.out);
  EXPECT_FALSE(desk.sent(Command::set_utc_time).has_value());
}

TEST(Requests, ARebootIsALossThatIsKnownAndTheTimeIsToldOnce) {
  Desk desk;
  desk.sample();
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, SetUtcTimeRequest{{1'600'000'000'000'000'000}}, desk.out));
  desk.pass(500);
  EXPECT_EQ(desk.outcome(Command::set_utc_time), Outcome::unanswered);
  EXPECT_EQ(desk.count_sent(Command::set_utc_time), 1U);
  ASSERT_TRUE(desk.protocol.request(desk.now_ns, 0, RebootRequest{1000}, desk.out));
  desk.answer(RebootAck{});
  ASSERT_THAT(desk.told<Lost>(), SizeIs(1));
  EXPECT_EQ(desk.told<Lost>()[0].cause, LossCause::rebooting);
  desk.pass(2000);
  desk.hear_broadcast();
  EXPECT_EQ(desk.state(), LinkState::handshaking);
}

}  // namespace
}  // namespace rigcal::livox
