// A virtual device as hosts of all kinds find it.
#include "simdata/live/virtual_livox.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace rigcal::sim {
namespace {

using namespace livox;
using testing::SizeIs;

constexpr std::int64_t ms = 1'000'000;
const Endpoint host{{192, 168, 1, 5}, 55501};
const Endpoint other_host{{192, 168, 1, 6}, 55501};

VirtualLivoxOptions avia() {
  VirtualLivoxOptions options;
  options.identity = {"3JEDK380010Z391", DeviceType::avia, kDevicePort};
  options.ip = {192, 168, 1, 139};
  return options;
}

class VirtualDevice : public testing::Test {
 protected:
  void switch_on(const VirtualLivoxOptions& options) { device.emplace(options, now); }
  void pass(std::int64_t milliseconds) {
    for (const std::int64_t end = now + milliseconds * ms; now < end;) {
      now = std::min(end, now + 10 * ms);
      device->tick(now, sent);
    }
  }
  // The answer to a request; nothing where the device is silent.
  std::optional<ControlPayload> ask(const ControlPayload& request, const Endpoint& from = host) {
    sent.clear();
    device->receive(now, from, encode_control(request, ++seq), sent);
    for (const DeviceFrame& frame : sent) {
      const auto parsed = parse_control_frame(frame.bytes);
      if (!parsed || parsed->type != FrameType::ack) continue;
      EXPECT_EQ(parsed->seq, seq);
      EXPECT_EQ(frame.to, from);
      const auto payload = decode_control(*parsed);
      EXPECT_TRUE(payload.has_value());
      return *payload;
    }
    return std::nullopt;
  }
  template <class Ack>
  Ack answer(const ControlPayload& request, const Endpoint& from = host) {
    const auto payload = ask(request, from);
    EXPECT_TRUE(payload && std::holds_alternative<Ack>(*payload));
    return payload && std::holds_alternative<Ack>(*payload) ? std::get<Ack>(*payload) : Ack{};
  }
  void take(const Endpoint& from = host) {
    EXPECT_EQ(answer<HandshakeAck>(Handshake{from.ip, 56001, from.port, std::uint16_t{56002}}, from).ret,
              ReturnCode::success);
  }
  std::size_t count(Command command) const {
    std::size_t found = 0;
    for (const DeviceFrame& frame : sent) {
      const auto parsed = parse_control_frame(frame.bytes);
      if (parsed && command_of(*parsed) == command) ++found;
    }
    return found;
  }

  std::int64_t now = 1000 * ms;
  std::optional<VirtualLivox> device;
  std::vector<DeviceFrame> sent;
  std::uint16_t seq = 0;
};

TEST_F(VirtualDevice, BroadcastsUntilItIsTakenAndAgainWhenTheHeartbeatsStop) {
  switch_on(avia());
  pass(3500);
  ASSERT_EQ(count(Command::broadcast), 4U);
  EXPECT_EQ(sent[0].to, (Endpoint{{255, 255, 255, 255}, 55000}));
  const auto first = parse_control_frame(sent[0].bytes);
  EXPECT_EQ(first->seq + 3, parse_control_frame(sent[3].bytes)->seq);
  EXPECT_EQ(parse_broadcast(*first)->broadcast_code, "3JEDK380010Z391");
  take();
  sent.clear();
  pass(4900);
  EXPECT_TRUE(sent.empty());
  EXPECT_TRUE(device->owner().has_value());
  pass(200);
  EXPECT_EQ(count(Command::broadcast), 1U);
  EXPECT_FALSE(device->owner().has_value());
}

TEST_F(VirtualDevice, TakesEveryFormOfTheHandshake) {
  switch_on(avia());
  for (const FrameType type : {FrameType::command, FrameType::ack}) {
    for (const bool has_imu_port : {true, false}) {
      Handshake handshake{host.ip, 56001, 55501, {}};
      if (has_imu_port) handshake.imu_port = std::uint16_t{56777};
      sent.clear();
      device->receive(now, host, make_handshake(handshake, 7, type), sent);
      const auto ack = std::find_if(sent.begin(), sent.end(), [](const DeviceFrame& f) { return f.to == host; });
      ASSERT_NE(ack, sent.end());
      EXPECT_EQ(parse_control_frame(ack->bytes)->seq, 7);
      EXPECT_EQ(device->owner()->imu_port, has_imu_port ? 56777 : 56001);
    }
  }
}

TEST_F(VirtualDevice, HasOneOwner) {
  switch_on(avia());
  take();
  EXPECT_EQ(answer<HandshakeAck>(Handshake{other_host.ip, 1, 2, {}}, other_host).ret, ReturnCode::failure);
  EXPECT_FALSE(ask(HeartbeatRequest{}, other_host).has_value());
  EXPECT_EQ(answer<CoordinatesAck>(CoordinatesRequest{}, other_host).ret, ReturnCode::failure);
  EXPECT_EQ(answer<DisconnectAck>(DisconnectRequest{}).ret, ReturnCode::success);
  take(other_host);
  device->set_owned_by_other(true);
  EXPECT_EQ(answer<HandshakeAck>(Handshake{host.ip, 1, 2, {}}).ret, ReturnCode::failure);
}

TEST_F(VirtualDevice, RefusesAHostThatHasNoPortForPoints) {
  switch_on(avia());
  EXPECT_EQ(answer<HandshakeAck>(Handshake{host.ip, 0, host.port, std::uint16_t{56002}}).ret, ReturnCode::failure);
  EXPECT_FALSE(device->owner().has_value());
  take();
  EXPECT_EQ(answer<HandshakeAck>(Handshake{host.ip, 0, host.port, {}}).ret, ReturnCode::failure);
  EXPECT_EQ(device->owner()->data_port, 56001) << "it goes on as it was told before";
}

TEST_F(VirtualDevice, AnswersNoHeartbeatWithoutAnOwner) {
  switch_on(avia());
  EXPECT_FALSE(ask(HeartbeatRequest{}).has_value());
}

TEST_F(VirtualDevice, SpinsUpBeforeItSamples) {
  switch_on(avia());
  pass(500);
  take();
  EXPECT_EQ(answer<SamplingAck>(SamplingRequest{Sampling::start}).ret, ReturnCode::failure);
  const auto spinning = answer<HeartbeatAck>(HeartbeatRequest{});
  EXPECT_EQ(spinning.state, WorkState::initialising);
  EXPECT_NEAR(spinning.progress_or_status, 25.0, 1.0);
  pass(1500);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).state, WorkState::normal);
  EXPECT_EQ(answer<SamplingAck>(SamplingRequest{Sampling::start}).ret, ReturnCode::success);
  EXPECT_TRUE(device->is_sampling());
  EXPECT_EQ(answer<SamplingAck>(SamplingRequest{Sampling::stop}).ret, ReturnCode::success);
  EXPECT_FALSE(device->is_sampling());
}

TEST_F(VirtualDevice, SwitchesPowerModes) {
  switch_on(avia());
  pass(2000);
  take();
  answer<SamplingAck>(SamplingRequest{Sampling::start});
  EXPECT_EQ(answer<SetPowerModeAck>(SetPowerModeRequest{PowerMode::standby}).ret, ReturnCode::success);
  EXPECT_FALSE(device->is_sampling());
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).state, WorkState::standby);
  EXPECT_EQ(answer<SetPowerModeAck>(SetPowerModeRequest{PowerMode::normal}).ret, ReturnCode::switching);
  pass(2000);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).state, WorkState::normal);
  EXPECT_EQ(answer<SetPowerModeAck>(SetPowerModeRequest{PowerMode::normal}).ret, ReturnCode::success);
}

TEST_F(VirtualDevice, RebootsAsToldAndForgetsItsOwner) {
  switch_on(avia());
  pass(2000);
  take();
  const std::int64_t booted = device->booted_ns();
  EXPECT_EQ(answer<RebootAck>(RebootRequest{200}).ret, ReturnCode::success);
  pass(190);
  EXPECT_TRUE(ask(HeartbeatRequest{}).has_value());
  pass(500);
  EXPECT_FALSE(ask(HeartbeatRequest{}).has_value());
  EXPECT_TRUE(device->is_silent(now));
  sent.clear();
  pass(1000);
  EXPECT_GE(count(Command::broadcast), 1U);
  EXPECT_GT(device->booted_ns(), booted);
  EXPECT_EQ(device->work_state(), WorkState::initialising);
}

TEST_F(VirtualDevice, TellsAnAbnormalStatusTenTimesASecond) {
  switch_on(avia());
  pass(2000);
  take();
  device->set_status(0x40000001);
  sent.clear();
  pass(1000);
  EXPECT_EQ(count(Command::abnormal_status), 10U);
  EXPECT_EQ(sent[0].to, host);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).progress_or_status, 0x40000001U);
  device->set_status(0x80000002);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).state, WorkState::error);
  EXPECT_EQ(answer<SamplingAck>(SamplingRequest{Sampling::start}).ret, ReturnCode::failure);
  device->set_status(0);
  pass(2100);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).state, WorkState::normal);
}

TEST_F(VirtualDevice, RemembersItsSettings) {
  switch_on(avia());
  take();
  EXPECT_EQ(answer<DeviceInformationAck>(DeviceInformationRequest{}).value, (FirmwareVersion{11, 9, 0, 0}));
  EXPECT_EQ(device->settings().point_type(), DataType::cartesian_tagged);
  answer<CoordinatesAck>(CoordinatesRequest{Coordinates::spherical});
  answer<SetReturnModeAck>(SetReturnModeRequest{Echoes::triple});
  EXPECT_EQ(device->settings().point_type(), DataType::triple_spherical);
  EXPECT_EQ(answer<GetReturnModeAck>(GetReturnModeRequest{}).value, Echoes::triple);
  EXPECT_TRUE(device->settings().sends_imu());
  answer<SetImuRateAck>(SetImuRateRequest{ImuRate::off});
  EXPECT_FALSE(device->settings().sends_imu());
  EXPECT_EQ(answer<GetImuRateAck>(GetImuRateRequest{}).value, ImuRate::off);
  const StoredExtrinsics mounting{1.0F, 2.0F, 3.0F, 4, 5, 6};
  answer<WriteExtrinsicsAck>(WriteExtrinsicsRequest{mounting});
  EXPECT_EQ(answer<ReadExtrinsicsAck>(ReadExtrinsicsRequest{}).value, mounting);
  answer<SetIpModeAck>(SetIpModeRequest{IpMode::fixed, {10, 0, 0, 9}, Subnet{{255, 0, 0, 0}, {10, 0, 0, 1}}});
  EXPECT_EQ(answer<GetIpModeAck>(GetIpModeRequest{}).ip, (Ipv4{10, 0, 0, 9}));
  EXPECT_EQ(answer<SetUtcTimeAck>(SetUtcTimeRequest{{1'600'000'000'000'000'000}}).ret, ReturnCode::success);
}

TEST_F(VirtualDevice, AnswersParametersWithTheirErrors) {
  switch_on(avia());
  take();
  answer<WriteParametersAck>(WriteParametersRequest{{{2, {1}}}});
  const auto read = answer<ReadParametersAck>(ReadParametersRequest{{1, 2}});
  ASSERT_THAT(read.parameters, SizeIs(2));
  EXPECT_EQ(read.parameters[1], (Parameter{2, {1}}));
  EXPECT_EQ(answer<WriteParametersAck>(WriteParametersRequest{{{9, {1}}}}).error, ParameterError::key_not_supported);
  EXPECT_EQ(answer<WriteParametersAck>(WriteParametersRequest{{{2, {7}}}}).error, ParameterError::wrong_value);
  EXPECT_EQ(answer<WriteParametersAck>(WriteParametersRequest{{{2, {1, 1}}}}).error, ParameterError::wrong_length);
  answer<ResetParametersAck>(ResetParametersRequest::all());
  EXPECT_EQ(answer<ReadParametersAck>(ReadParametersRequest{{2}}).parameters[0], (Parameter{2, {0}}));
  EXPECT_EQ(answer<ReadParametersAck>(ReadParametersRequest{std::vector<std::uint16_t>(200, 1)}).error,
            ParameterError::buffer_too_small);
}

TEST_F(VirtualDevice, AMid40KnowsLess) {
  VirtualLivoxOptions options = avia();
  options.identity = {"0TFDG3B00600552", DeviceType::mid40, kDevicePort};
  options.ip = {192, 168, 1, 91};
  switch_on(options);
  take();
  EXPECT_EQ(answer<SetReturnModeAck>(SetReturnModeRequest{Echoes::dual}).ret, ReturnCode::failure);
  EXPECT_EQ(answer<SetImuRateAck>(SetImuRateRequest{ImuRate::hz_200}).ret, ReturnCode::failure);
  EXPECT_EQ(answer<ReadParametersAck>(ReadParametersRequest{{1}}).ret, ReturnCode::failure);
  EXPECT_EQ(answer<RainSuppressionAck>(RainSuppressionRequest{Switch::on}).ret, ReturnCode::success);
  EXPECT_EQ(answer<HeartbeatAck>(HeartbeatRequest{}).features, 1);
  EXPECT_FALSE(answer<GetIpModeAck>(GetIpModeRequest{}).subnet.has_value());
  // The middle unit of a Mid-100 has the addresses from .81 to .150.
  EXPECT_EQ(answer<SetIpModeAck>(SetIpModeRequest{IpMode::fixed, {192, 168, 1, 80}, {}}).ret, ReturnCode::failure);
  EXPECT_EQ(answer<SetIpModeAck>(SetIpModeRequest{IpMode::fixed, {192, 168, 1, 81}, {}}).ret, ReturnCode::success);
  EXPECT_EQ(device->settings().point_type(), DataType::cartesian);
  EXPECT_EQ(answer<SetFanAck>(SetFanRequest{Switch::off}).ret, ReturnCode::success);
  EXPECT_EQ(answer<GetFanAck>(GetFanRequest{}).value, Switch::off);
}

TEST_F(VirtualDevice, EveryModelSaysWhoItIs) {
  for (const DeviceType type :
       {DeviceType::mid40, DeviceType::tele15, DeviceType::horizon, DeviceType::mid70, DeviceType::avia}) {
    VirtualLivoxOptions options = avia();
    options.identity.type = type;
    switch_on(options);
    take();
    EXPECT_GT(answer<DeviceInformationAck>(DeviceInformationRequest{}).value[0], 2) << model_name(type);
  }
}

TEST_F(VirtualDevice, RefusesWhatItDoesNotKnowAndWhatItIsToldTo) {
  switch_on(avia());
  take();
  sent.clear();
  device->receive(now, host, make_control_frame({FrameType::command, 77, CommandSet::lidar, 0x55, {}}), sent);
  ASSERT_THAT(sent, SizeIs(1));
  const auto refusal = parse_control_frame(sent[0].bytes);
  EXPECT_EQ(refusal->seq, 77);
  EXPECT_EQ(refusal->payload[0], 1);
  device->refuse(Command::coordinates);
  EXPECT_EQ(answer<CoordinatesAck>(CoordinatesRequest{}).ret, ReturnCode::failure);
  sent.clear();
  device->receive(now, host, std::vector<std::uint8_t>(40, 0xAA), sent);
  device->receive(now, host, encode_control(HeartbeatAck{}, 3), sent);
  EXPECT_TRUE(sent.empty());
}

VirtualLivoxOptions with_pulses() {
  VirtualLivoxOptions options = avia();
  options.time.source = TimeSource::pps;
  options.time.pulse_ns = 250 * ms;
  return options;
}

TEST_F(VirtualDevice, WithPulsesTakesTheTimeOfDayAndStampsByIt) {
  switch_on(with_pulses());
  take();
  EXPECT_EQ(device->time().type(), TimestampType::pps_only);
  EXPECT_EQ(device->time().stamp_ns(now), 750 * ms);  // 1.0 s, and pulses at 0.25, 1.25 and so on.
  EXPECT_EQ(device->time().stamp_ns(100 * ms), 850 * ms);
  EXPECT_TRUE(decode_status(device->status()).pps_ok);
  EXPECT_EQ(decode_status(device->status()).time_sync, TimeSync::pps);
  constexpr std::int64_t noon = 1'600'000'000'000 * ms;
  now = 5255 * ms;  // 5 ms after a pulse, and then 510.
  EXPECT_EQ(answer<SetUtcTimeAck>(SetUtcTimeRequest{{noon}}).ret, ReturnCode::failure);
  now = 5760 * ms;
  EXPECT_EQ(answer<SetUtcTimeAck>(SetUtcTimeRequest{{noon}}).ret, ReturnCode::failure);
  EXPECT_EQ(device->time().type(), TimestampType::pps_only);
  answer<HeartbeatAck>(HeartbeatRequest{});
  now = 6350 * ms;
  EXPECT_EQ(answer<SetUtcTimeAck>(SetUtcTimeRequest{{noon}}).ret, ReturnCode::success);
  EXPECT_EQ(device->time().type(), TimestampType::gps);
  EXPECT_EQ(device->time().stamp_ns(6250 * ms), noon);
  EXPECT_EQ(device->time().stamp_ns(7400 * ms), noon + 1150 * ms);
  device->tick(now, sent);  // Spun up meanwhile.
  EXPECT_EQ(decode_status(answer<HeartbeatAck>(HeartbeatRequest{}).progress_or_status).time_sync, TimeSync::gps);
}

TEST_F(VirtualDevice, ForgetsTheTimeOfDayThatNobodyTellsAgain) {
  switch_on(with_pulses());
  take();
  pass(2500);
  answer<HeartbeatAck>(HeartbeatRequest{});
  now = 6350 * ms;
  answer<SetUtcTimeAck>(SetUtcTimeRequest{{1'600'000'000'000 * ms}});
  EXPECT_EQ(decode_status(device->status()).time_sync, TimeSync::gps);
  EXPECT_LE(device->deadline_ns(), now + 3000 * ms);
  pass(3000);
  EXPECT_EQ(decode_status(device->status()).time_sync, TimeSync::abnormal);
  EXPECT_EQ(device->time().type(), TimestampType::pps_only);
  device->reboot(now);
  pass(1500);
  EXPECT_EQ(decode_status(device->status()).time_sync, TimeSync::pps);
}

TEST_F(VirtualDevice, FollowsAMasterOfPtp) {
  VirtualLivoxOptions options = avia();
  options.time.source = TimeSource::ptp;
  options.time.utc_offset_ns = 1'600'000'000'000 * ms;
  switch_on(options);
  EXPECT_EQ(device->time().type(), TimestampType::ptp);
  EXPECT_EQ(device->time().stamp_ns(7 * ms), 1'600'000'000'007 * ms);
  device->set_status(0x40);
  EXPECT_EQ(decode_status(device->status()).time_sync, TimeSync::ptp);
  EXPECT_TRUE(decode_status(device->status()).ptp_ok);
  EXPECT_EQ(decode_status(device->status()).dirty, 1);
}

TEST_F(VirtualDevice, KeepsTheEchoesOfARecording) {
  switch_on(avia());
  take();
  device->wake_with(DataType::dual_cartesian, false);
  device->keep_echoes();
  EXPECT_EQ(answer<SetReturnModeAck>(SetReturnModeRequest{Echoes::triple}).ret, ReturnCode::failure);
  EXPECT_EQ(answer<SetReturnModeAck>(SetReturnModeRequest{Echoes::dual}).ret, ReturnCode::success);
  EXPECT_EQ(answer<CoordinatesAck>(CoordinatesRequest{Coordinates::spherical}).ret, ReturnCode::success);
  EXPECT_EQ(device->settings().point_type(), DataType::dual_spherical);
}

TEST_F(VirtualDevice, FallsSilentAndComesBack) {
  switch_on(avia());
  take();
  device->fall_silent(now + 1000 * ms);
  EXPECT_FALSE(ask(HeartbeatRequest{}).has_value());
  pass(1000);
  EXPECT_TRUE(ask(HeartbeatRequest{}).has_value());
}

TEST_F(VirtualDevice, FaultsHappenAsOftenAsAskedFor) {
  VirtualLivoxOptions options = avia();
  options.faults = {0.2, 0.2, 0.2, 0.05, 0.0, 0.2};
  switch_on(options);
  std::size_t frames = 0;
  std::size_t damaged = 0;
  device->set_owned_by_other(true);
  constexpr int asked = 2000;
  for (int i = 0; i < asked; ++i) {
    sent.clear();
    device->receive(now, host, encode_control(GetIpModeRequest{}, 5), sent);
    pass(60);
    frames += sent.size();
    for (const DeviceFrame& frame : sent)
      if (!parse_control_frame(frame.bytes)) ++damaged;
  }
  EXPECT_NEAR(static_cast<double>(frames) / asked, 0.8 * 1.2, 0.05);
  EXPECT_NEAR(static_cast<double>(damaged) / static_cast<double>(frames), 0.2, 0.04);
}

}  // namespace
}  // namespace rigcal::sim
