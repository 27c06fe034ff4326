// Who may do what with a virtual camera, and what it answers to what goes wrong.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/simdata/gige/camera_desk.h"
#include "tests/support/mutations.h"

namespace rigcal::sim {
namespace {

namespace bootstrap = gige::bootstrap;
using gige::Status;

TEST(CameraControl, AnswersADiscoveryWithItsIdentity) {
  CameraDesk desk;
  const auto reply = desk.ask(desk.stranger, gige::DiscoveryRequest{});
  ASSERT_TRUE(reply && reply->ack);
  const auto& identity = std::get<gige::DeviceIdentity>(*reply->ack);
  EXPECT_EQ(identity.model, "MV-CA013-21UC");
  EXPECT_EQ(identity.serial, "00F12345678");
  EXPECT_EQ(identity.ip, (gige::Ipv4{192, 168, 1, 31}));
  EXPECT_EQ(desk.out.answers[0].to, desk.stranger);
}

TEST(CameraControl, OneHostAtATimeMayWrite) {
  CameraDesk desk;
  EXPECT_EQ(desk.write(desk.host, address_of(Feature::gain), 0), Status::access_denied);
  desk.take_control();
  EXPECT_EQ(desk.write(desk.host, address_of(Feature::gain), 0), Status::success);
  EXPECT_EQ(desk.write(desk.stranger, address_of(Feature::gain), 0), Status::access_denied);
  EXPECT_EQ(desk.write(desk.stranger, bootstrap::kPrivilege, gige::kControl), Status::access_denied);
  EXPECT_EQ(desk.write(desk.stranger, bootstrap::kPrivilege, 0), Status::access_denied);
  EXPECT_EQ(desk.ask(desk.stranger, gige::ReadRegistersRequest{{bootstrap::kVersion}})->status, Status::success);
  EXPECT_EQ(desk.read(bootstrap::kPrimaryPort), 40001U);
  EXPECT_EQ(desk.read(bootstrap::kPrimaryIp), 0xC0A80105U);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kPrivilege, 0), Status::success);
  EXPECT_EQ(desk.write(desk.stranger, bootstrap::kPrivilege, gige::kControl), Status::success);
}

TEST(CameraControl, AnExclusiveHostLetsOthersReadNothingButWhoHasIt) {
  CameraDesk desk;
  desk.take_control(gige::kExclusive);
  EXPECT_EQ(desk.ask(desk.stranger, gige::ReadRegistersRequest{{bootstrap::kVersion}})->status, Status::access_denied);
  EXPECT_EQ(desk.ask(desk.stranger, gige::ReadMemoryRequest{0, 8})->status, Status::access_denied);
  const auto reply = desk.ask(desk.stranger, gige::ReadRegistersRequest{{bootstrap::kPrivilege}});
  EXPECT_EQ(std::get<gige::ReadRegistersAck>(*reply->ack).values, std::vector{gige::kExclusive});
  EXPECT_TRUE(desk.ask(desk.stranger, gige::DiscoveryRequest{})->ack.has_value());
}

TEST(CameraControl, WithoutAHeartbeatItFreesItselfAndStopsStreaming) {
  CameraDesk desk;
  desk.take_control();
  desk.open_stream();
  EXPECT_EQ(desk.write(desk.host, bootstrap::kHeartbeatTimeout, 600), Status::success);
  EXPECT_EQ(desk.write(Feature::acquisition_start, 1), Status::success);
  desk.now_ns += 599'000'000;
  desk.camera.tick(desk.now_ns, desk.out);
  EXPECT_TRUE(desk.camera.owner().has_value());
  EXPECT_LE(desk.camera.deadline_ns(), desk.now_ns + 1'000'000);
  // Another one's commands do not keep it.
  static_cast<void>(desk.ask(desk.stranger, gige::ReadRegistersRequest{{bootstrap::kVersion}}));
  desk.now_ns += 1'000'000;
  desk.out.clear();
  desk.camera.tick(desk.now_ns, desk.out);
  EXPECT_FALSE(desk.camera.owner().has_value());
  EXPECT_FALSE(desk.camera.is_acquiring());
  EXPECT_TRUE(desk.out.is_stream_closed);
  EXPECT_EQ(desk.read(bootstrap::kPrivilege), 0U);
  EXPECT_EQ(desk.read(bootstrap::kStreamPort), 0U);
  EXPECT_EQ(desk.write(desk.stranger, bootstrap::kPrivilege, gige::kControl), Status::success);
}

TEST(CameraControl, AHeartbeatCanBeSwitchedOffAndHasLimits) {
  CameraDesk desk;
  desk.take_control();
  EXPECT_EQ(desk.write(desk.host, bootstrap::kHeartbeatTimeout, 1), Status::success);
  EXPECT_EQ(desk.read(bootstrap::kHeartbeatTimeout), 500U);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kControlConfiguration, gige::kHeartbeatOff), Status::success);
  desk.now_ns += 3600 * second_ns;
  desk.camera.tick(desk.now_ns, desk.out);
  EXPECT_TRUE(desk.camera.owner().has_value());
  EXPECT_GT(desk.camera.deadline_ns(), desk.now_ns);
}

TEST(CameraControl, RefusesByTheStandardsNumbers) {
  CameraDesk desk;
  desk.take_control();
  const auto read = [&](std::vector<std::uint32_t> addresses) {
    return desk.ask(desk.host, gige::ReadRegistersRequest{std::move(addresses)});
  };
  EXPECT_EQ(read({0x0001})->status, Status::bad_alignment);
  EXPECT_EQ(read({0x0A20})->status, Status::invalid_address);
  EXPECT_EQ(read({0xFFFF'FFFC})->status, Status::invalid_address);
  const auto some = read({bootstrap::kVersion, 0x0A20});
  EXPECT_EQ(some->status, Status::invalid_address);
  EXPECT_EQ(std::get<gige::ReadRegistersAck>(*some->ack).values.size(), 1U);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kVersion, 1), Status::write_protected);
  EXPECT_EQ(desk.ask(desk.host, gige::ReadMemoryRequest{0, 537})->status, Status::invalid_parameter);
  EXPECT_EQ(desk.ask(desk.host, gige::ReadMemoryRequest{0, 0})->status, Status::invalid_parameter);
  EXPECT_EQ(desk.ask(desk.host, gige::ReadMemoryRequest{0, 6})->status, Status::bad_alignment);
  EXPECT_EQ(desk.ask(desk.host, gige::WriteMemoryRequest{bootstrap::kUserName, {1, 2, 3}})->status,
            Status::bad_alignment);
  EXPECT_EQ(desk.ask(desk.host, gige::WriteMemoryRequest{0xFFFF'FFF0, std::vector<std::uint8_t>(64)})->status,
            Status::invalid_address);
  const auto writes = desk.ask(
      desk.host, gige::WriteRegistersRequest{{{address_of(Feature::gain), 0}, {bootstrap::kVersion, 1}, {0, 0}}});
  EXPECT_EQ(writes->status, Status::write_protected);
  EXPECT_EQ(std::get<gige::WriteRegistersAck>(*writes->ack).written, 1);
  EXPECT_EQ(desk.say(desk.host, {0x42, 1, 0x01, 0x00, 0, 0, 0, 9})->status, Status::not_implemented);
  EXPECT_EQ(desk.say(desk.host, {0x42, 1, 0x00, 0x80, 0, 2, 0, 9, 0, 0})->status, Status::invalid_header);
  EXPECT_FALSE(desk.say(desk.host, {0x42, 0, 0x01, 0x00, 0, 0, 0, 9}).has_value());  // It wants no ack.
  EXPECT_FALSE(desk.say(desk.host, {1, 2, 3}).has_value());
}

TEST(CameraControl, ItsUserNameIsWrittenAndFound) {
  CameraDesk desk;
  desk.take_control();
  std::vector<std::uint8_t> name(16);
  std::copy_n("left", 4, name.begin());
  EXPECT_EQ(desk.ask(desk.host, gige::WriteMemoryRequest{bootstrap::kUserName, name})->status, Status::success);
  const auto reply = desk.ask(desk.stranger, gige::DiscoveryRequest{});
  EXPECT_EQ(std::get<gige::DeviceIdentity>(*reply->ack).user_name, "left");
}

TEST(CameraControl, ACommandThatComesTwiceIsDoneOnceAndAnsweredTwice) {
  CameraDesk desk;
  desk.take_control();
  desk.open_stream();
  desk.write(Feature::trigger_mode, 1);
  desk.write(Feature::trigger_source, kSoftwareTrigger);
  desk.write(Feature::acquisition_start, 1);
  const auto bytes =
      gige::encode_request(gige::WriteRegistersRequest{{{address_of(Feature::trigger_software), 1}}}, 777);
  EXPECT_EQ(desk.say(desk.host, bytes)->status, Status::success);
  desk.now_ns += second_ns / 10;
  EXPECT_EQ(desk.say(desk.host, bytes)->id, 777);
  EXPECT_EQ(desk.out.frames.size(), 1U);  // It came out with the second answer.
  desk.out.clear();
  EXPECT_TRUE(desk.wait(second_ns / 2).empty());
  EXPECT_EQ(desk.camera.ignored_triggers(), 0U);
}

TEST(CameraControl, ASlowOneSaysThatItsAnswerIsPending) {
  VirtualCameraOptions options = desk_camera();
  options.answer_delay_s = 0.8;
  CameraDesk desk(options);
  const auto pending = desk.ask(desk.host, gige::ReadRegistersRequest{{bootstrap::kVersion}});
  ASSERT_TRUE(pending && pending->ack);
  EXPECT_EQ(std::get<gige::PendingAck>(*pending->ack).milliseconds, 800);
  EXPECT_EQ(desk.camera.deadline_ns(), desk.now_ns + 800'000'000);
  desk.out.clear();
  desk.now_ns += 800'000'000;
  desk.camera.tick(desk.now_ns, desk.out);
  ASSERT_TRUE(desk.last_reply().has_value());
  EXPECT_EQ(desk.last_reply()->id, pending->id);
  EXPECT_TRUE(std::holds_alternative<gige::ReadRegistersAck>(*desk.last_reply()->ack));
}

TEST(CameraControl, OnlyItsOwnerGetsPacketsAgain) {
  CameraDesk desk;
  desk.take_control();
  EXPECT_FALSE(desk.ask(desk.host, gige::ResendRequest{0, 5, 1, 3}).has_value());
  ASSERT_EQ(desk.out.resends.size(), 1U);
  EXPECT_EQ(desk.out.resends[0], (gige::ResendRequest{0, 5, 1, 3}));
  static_cast<void>(desk.ask({desk.host.ip, 50500}, gige::ResendRequest{0, 5, 1, 3}));  // From its stream's port.
  EXPECT_EQ(desk.out.resends.size(), 1U);
  static_cast<void>(desk.ask(desk.stranger, gige::ResendRequest{0, 5, 1, 3}));
  EXPECT_TRUE(desk.out.resends.empty());
  static_cast<void>(desk.ask(desk.host, gige::ResendRequest{1, 5, 1, 3}));  // A channel that it does not have.
  EXPECT_TRUE(desk.out.resends.empty());
}

TEST(CameraControl, TakesAnAddressByForceFromWhoeverKnowsItsMac) {
  CameraDesk desk;
  gige::ForceIpRequest request{{1, 2, 3, 4, 5, 6}, {10, 0, 0, 7}, {255, 0, 0, 0}, {}};
  EXPECT_FALSE(desk.ask(desk.stranger, request).has_value());
  request.mac = desk_camera().identity.mac;
  EXPECT_EQ(desk.ask(desk.stranger, request)->status, Status::success);
  EXPECT_EQ(desk.out.new_address, (gige::Ipv4{10, 0, 0, 7}));
  EXPECT_EQ(desk.camera.ip(), (gige::Ipv4{10, 0, 0, 7}));
  EXPECT_EQ(desk.read(bootstrap::kIp), 0x0A000007U);
  desk.take_control();
  EXPECT_EQ(desk.ask(desk.stranger, request)->status, Status::access_denied);
}

TEST(CameraControl, ResetItIsDarkForAWhileAndAsAtTheStart) {
  CameraDesk desk;
  desk.take_control();
  desk.open_stream();
  desk.write_real(Feature::exposure_time, 1234.0F);
  EXPECT_EQ(desk.write(Feature::device_reset, 1), Status::success);
  desk.wait(second_ns / 10);
  EXPECT_TRUE(desk.camera.is_silent(desk.now_ns));
  EXPECT_FALSE(desk.ask(desk.host, gige::DiscoveryRequest{}).has_value());
  desk.wait(2 * second_ns);
  EXPECT_TRUE(desk.ask(desk.host, gige::DiscoveryRequest{}).has_value());
  EXPECT_FALSE(desk.camera.owner().has_value());
  EXPECT_EQ(desk.read_real(Feature::exposure_time), 5000.0F);
  EXPECT_EQ(desk.read(bootstrap::kStreamPort), 0U);
}

TEST(CameraControl, SilentItHearsNothing) {
  CameraDesk desk;
  desk.camera.fall_silent(desk.now_ns + second_ns);
  EXPECT_FALSE(desk.ask(desk.host, gige::DiscoveryRequest{}).has_value());
  desk.now_ns += second_ns;
  EXPECT_TRUE(desk.ask(desk.host, gige::DiscoveryRequest{}).has_value());
}

TEST(CameraControl, TakenByAnotherHostItRefusesEverybody) {
  CameraDesk desk;
  desk.take_control();
  desk.out.clear();
  desk.camera.set_owned_by_other(true, desk.out);
  EXPECT_TRUE(desk.out.is_stream_closed);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kPrivilege, gige::kControl), Status::access_denied);
  EXPECT_EQ(desk.ask(desk.host, gige::ReadRegistersRequest{{bootstrap::kVersion}})->status, Status::access_denied);
  desk.camera.set_owned_by_other(false, desk.out);
  desk.take_control();
}

TEST(CameraControl, SurvivesAnyBytes) {
  CameraDesk desk;
  desk.take_control();
  desk.open_stream();
  const std::vector<std::vector<std::uint8_t>> commands{
      gige::encode_request(gige::WriteRegistersRequest{{{address_of(Feature::width), 640}, {0x0D04, 0x800005DC}}}, 5),
      gige::encode_request(gige::WriteMemoryRequest{bootstrap::kUserName, std::vector<std::uint8_t>(16, 65)}, 6),
      gige::encode_request(gige::ReadMemoryRequest{0x10000, 512}, 7),
      gige::encode_request(gige::ResendRequest{0, 1, 0, 100}, 8),
  };
  Random random(3);
  std::size_t answers = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto bytes = mutated(commands[static_cast<std::size_t>(i) % commands.size()], random);
    desk.out.clear();
    desk.now_ns += 1'000'000;
    desk.camera.receive(desk.now_ns, desk.host, bytes, desk.out);
    answers += desk.out.answers.size();
    const CameraSettings settings = desk.camera.settings();
    ASSERT_GE(settings.width, 32);
    ASSERT_LE(settings.width + settings.offset_x, 1280);
    ASSERT_LE(settings.height + settings.offset_y, 1024);
    ASSERT_GE(desk.camera.stream().packet_bytes, 220U);
    ASSERT_LE(desk.camera.stream().packet_bytes, 9156U);
  }
  EXPECT_GT(answers, 1000U);
}

}  // namespace
}  // namespace rigcal::sim
