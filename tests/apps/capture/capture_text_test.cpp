#include "apps/capture/capture_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/capture/capture_log.h"
#include "apps/capture/capture_record.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::int64_t noon_ns = 1'790'000'000'000'000'000;  // 2026-09-21 14:13:20 UTC

CaptureSummary two_lidars() {
  CaptureSummary summary;
  summary.session = "session";
  summary.status.seconds = 12.4;
  summary.status.bytes = 45'000'000;
  summary.status.devices.resize(2);
  CaptureDevice& avia = summary.status.devices[0];
  avia.sensor = "avia";
  avia.report.packets = 30'000;
  avia.report.link.state = livox::LinkState::sampling;
  avia.report.link.work_state = livox::WorkState::normal;
  avia.report.link.status = 0x40006840;  // A real Tele-15: dirty, fan warning, synchronised by PTP.
  avia.packets_per_s = 2700.0;
  avia.expected = 30'300;
  avia.lost = 303;
  avia.drift_ppm = -3.14;
  CaptureDevice& left = summary.status.devices[1];
  left.sensor = "mid100_left";
  left.report.packets = 5;
  left.report.link.state = livox::LinkState::preparing;
  left.report.link.progress_percent = 40;
  livox::InterfaceReport& eth = summary.interfaces.emplace_back();
  eth.interface.name = "eth0";
  eth.interface.ip = {192, 168, 1, 5};
  eth.receive_bytes = 212'992;
  return summary;
}

TEST(CaptureLines, FitATerminalAndSayHowEachLidarDoes) {
  const auto lines = capture_lines(two_lidars().status);
  EXPECT_THAT(lines, ElementsAre("captured 12 s, 45.0 MB",
                                 "LiDAR           state        packets/s   lost %  temperature sync   clock ppm",
                                 "avia            sampling          2700     1.00  ok          PTP         -3.1",
                                 "mid100_left     starts 40 %          0     0.00  ok          none         0.0",
                                 "avia says: window dirty or blocked", "avia says: fan warning"));
  for (const std::string& line : lines) EXPECT_LE(line.size(), 79U);
}

TEST(CaptureCameras, HaveATableAPlaceInTheSummaryAndAWordInCompleteness) {
  CaptureSummary summary = two_lidars();
  for (CaptureDevice& device : summary.status.devices) device.report.packets = 1;
  EXPECT_TRUE(summary.is_complete());
  CaptureCamera& camera = summary.status.cameras.emplace_back();
  camera.sensor = "camera_left";
  camera.state = "sends";
  camera.written = 118;
  camera.frames_per_s = 9.96;
  camera.counters.frames = {118, 2, 0, 0, 0};
  camera.counters.missing = 3;
  const auto lines = capture_lines(summary.status);
  EXPECT_EQ(lines[lines.size() - 2], "camera          state         frames/s  missing  damaged  dropped");
  EXPECT_EQ(lines.back(), "camera_left     sends             10.0        3        2        0");
  EXPECT_TRUE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("camera_left: 118 images, 3 frames missing, 2 damaged, 0 dropped"));
  EXPECT_TRUE(fits_schema("capture.json", parse_json(capture_json(summary))));
  camera.matching.emplace();
  camera.matching->matched = 117;
  camera.matching->pulses_without_frame = 4;
  camera.matching->pulses_out_of_order = 1;
  camera.matching->frames_lost = 2;
  camera.matching->id_jumps = 3;
  camera.clock = CameraClockFigures{12.5, 2e3, 3e3, 117};
  summary.status.trigger.emplace();
  summary.status.trigger->pulses = 121;
  summary.status.trigger->strobe_lost = 5;
  summary.status.trigger->strobe_mended = 6;
  summary.status.trigger->pps_lost = 7;
  summary.status.trigger->lateness.add(40'000);
  EXPECT_EQ(capture_lines(summary.status).back(), "trigger: 121 pulses, 0 left out, set 40 us late (40 at most)");
  EXPECT_THAT(capture_text(summary), HasSubstr("117 of them with their pulse, 4 pulses without an image"));
  const auto json = parse_json(capture_json(summary));
  EXPECT_TRUE(fits_schema("capture.json", json));
  for (const auto& counters :
       {json["cameras"][0]["matching"], nlohmann::json(capture_counters({}, {}, summary.status, {})["camera_left"])}) {
    EXPECT_EQ(counters["pulses_out_of_order"], 1);
    EXPECT_EQ(counters["frames_lost"], 2);
    EXPECT_EQ(counters["id_jumps"], 3);
  }
  for (const auto& counters :
       {json["trigger"], nlohmann::json(capture_counters({}, {}, summary.status, {})["trigger"])}) {
    EXPECT_EQ(counters["strobe_lost"], 5);
    EXPECT_EQ(counters["strobe_mended"], 6);
    EXPECT_EQ(counters["pps_lost"], 7);
  }
  camera.dropped_by_queue = 1;
  EXPECT_FALSE(summary.is_complete());
  camera.dropped_by_queue = 0;
  camera.written = 0;
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("it never sent anything"));
  camera.written = 118;
  EXPECT_TRUE(summary.is_complete());
  camera.failure = system_error("cannot be written", "images/camera_left");
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("0 dropped: its images could not be written any more"));
}

TEST(CaptureSummary, IsCompleteWhereAllStayedAndNothingWasLostHere) {
  CaptureSummary summary = two_lidars();
  EXPECT_TRUE(summary.is_complete());
  summary.status.devices[1].report.link.counters.losses = 1;
  EXPECT_FALSE(summary.is_complete());
  summary = two_lidars();
  summary.status.devices[1].report.packets = 0;
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("it never sent anything"));
  summary = two_lidars();
  summary.interfaces[0].counters.dropped_by_kernel = 1;
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("incomplete"));
}

TEST(CaptureSummary, IsNotCompleteWhereALidarStoppedToSendThoughItAnswered) {
  CaptureSummary summary = two_lidars();
  summary.end_ns = noon_ns;
  for (CaptureDevice& device : summary.status.devices) device.report.last_packet_ns = noon_ns - 1'900'000'000;
  EXPECT_TRUE(summary.is_complete());
  summary.status.devices[0].report.last_packet_ns = noon_ns - 12'500'000'000;
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("avia: 30000 packets, 303 lost, nothing in the last 12 s\n"));
  summary.status.devices[0].report.last_packet_ns = noon_ns + 5;  // It came while the devices were being freed.
  EXPECT_TRUE(summary.is_complete());
  summary.status.devices[1].report.link.counters.interruptions = 2;
  EXPECT_FALSE(summary.is_complete());
  EXPECT_THAT(capture_text(summary), HasSubstr("mid100_left: 5 packets, 0 lost, interrupted 2 times\n"));
}

std::vector<std::string> messages_of(const CaptureSummary& summary) {
  std::vector<std::string> messages;
  for (const Shortfall& shortfall : summary.shortfalls()) messages.push_back(shortfall.message());
  return messages;
}

TEST(CaptureSummary, SaysAllThatKeepsItFromBeingComplete) {
  CaptureSummary summary = two_lidars();
  EXPECT_THAT(summary.shortfalls(), IsEmpty());
  summary.end_ns = noon_ns;
  summary.status.devices[0].report.last_packet_ns = noon_ns - 12'500'000'000;
  summary.status.devices[0].report.link.counters.losses = 1;
  summary.status.devices[0].report.link.counters.interruptions = 1;  // By the loss.
  summary.status.devices[1].report.packets = 0;
  summary.interfaces[0].counters.dropped_by_kernel = 40;
  summary.interfaces[0].counters.dropped_by_queue = 2;
  summary.dropped_control = 3;
  CaptureCamera& camera = summary.status.cameras.emplace_back();
  camera.sensor = "camera_left";
  camera.counters.losses = 2;
  summary.status.live.failure = system_error("cannot be read", "s/lidar.pcapng", "look after the disk");
  summary.status.progress.stops = 2;
  summary.status.progress.wanted_stops = 3;
  EXPECT_THAT(
      messages_of(summary),
      ElementsAre(
          "avia: its connection was lost 1 time", "avia: nothing came from it in the last 12 s",
          "mid100_left: it never sent anything", "eth0 192.168.1.5: 42 packets were lost in this machine",
          "3 control frames were not recorded", "camera_left: it never sent anything",
          "camera_left: its connection was lost 2 times",
          "the stops could not be found while it was recorded: s/lidar.pcapng: cannot be read; look after the disk",
          "only 2 of 3 stops are in"));
}

TEST(CaptureSummary, HasAKindForEachShortfall) {
  using Kind = Shortfall::Kind;
  const auto kinds_of = [](const CaptureSummary& summary) {
    std::vector<Kind> kinds;
    for (const Shortfall& shortfall : summary.shortfalls()) kinds.push_back(shortfall.kind);
    return kinds;
  };
  CaptureSummary summary = two_lidars();
  summary.end_ns = noon_ns;
  CaptureDevice& avia = summary.status.devices[0];
  avia.report.link.counters.losses = 1;
  avia.report.link.counters.interruptions = 2;
  avia.report.link.missing_settings = {{"return_mode: dual", livox::Outcome::unsupported}};
  summary.status.devices[1].report.packets = 0;
  CaptureCamera& camera = summary.status.cameras.emplace_back();
  camera.failure = system_error("cannot be written", "images/camera_left");
  camera.counters.no_buffer = 1;
  summary.status.progress.state = CaptureState::failed;
  summary.status.progress.wanted_stops = 1;
  EXPECT_THAT(kinds_of(summary), ElementsAre(Kind::connection_lost, Kind::interrupted, Kind::fell_silent,
                                             Kind::setting_missing, Kind::never_sent, Kind::images_unwritten,
                                             Kind::lost_here, Kind::failed, Kind::stops_missing));
  EXPECT_THAT(summary.shortfalls()[5].error->where, HasSubstr("camera_left"));
  avia.report.packets = 0;
  EXPECT_THAT(kinds_of(summary), ElementsAre(Kind::no_lidar, Kind::never_sent, Kind::never_sent, Kind::images_unwritten,
                                             Kind::lost_here, Kind::failed, Kind::stops_missing));
}

TEST(CaptureSummary, CountsInterruptionsOnceInTheLineOfALidar) {
  CaptureSummary summary = two_lidars();
  livox::LinkCounters& link = summary.status.devices[1].report.link.counters;
  link.losses = 1;
  EXPECT_THAT(capture_text(summary), HasSubstr("mid100_left: 5 packets, 0 lost\n"));
  link.interruptions = 1;
  EXPECT_THAT(capture_text(summary), HasSubstr("mid100_left: 5 packets, 0 lost, interrupted 1 time\n"));
  link.interruptions = 2;
  EXPECT_THAT(capture_text(summary), HasSubstr("mid100_left: 5 packets, 0 lost, interrupted 2 times\n"));
}

TEST(CaptureSummary, HasGapsOfLidarsThatNeverSentAndOfThoseThatFellSilent) {
  const auto gaps_of = [](const CaptureSummary& summary) {
    std::vector<std::string> gaps;
    for (const Shortfall& shortfall : summary.shortfalls())
      if (!shortfall.gap.empty()) gaps.push_back(shortfall.gap);
    return gaps;
  };
  CaptureSummary summary = two_lidars();
  summary.start_ns = noon_ns;
  summary.end_ns = noon_ns + 60'000'000'000;
  for (CaptureDevice& device : summary.status.devices) device.report.last_packet_ns = summary.end_ns - 1'000'000'000;
  EXPECT_THAT(gaps_of(summary), IsEmpty());
  summary.status.devices[0].report.last_packet_ns = noon_ns + 20'000'000'000;
  CaptureDevice& left = summary.status.devices[1];
  left.report.packets = 0;
  left.report.link.counters.losses = 1;  // The log has told of it when it happened.
  EXPECT_THAT(gaps_of(summary),
              ElementsAre("2026-09-21 14:13:40.000 avia: nothing came any more until the end, 40.0 s",
                          "2026-09-21 14:13:20.000 mid100_left: it never sent anything: no broadcast of it was heard"));
  left.report.link.counters.handshakes = 1;
  EXPECT_THAT(gaps_of(summary).back(), HasSubstr("though its broadcasts were heard"));
  left.report.link.firmware = {3, 8, 0, 0};
  EXPECT_THAT(gaps_of(summary).back(), HasSubstr("though it answered: let UDP through the firewall"));
}

TEST(CaptureSummary, IsNotCompleteWhereControlFramesWereNotRecorded) {
  CaptureSummary summary = two_lidars();
  summary.dropped_control = 1;
  EXPECT_FALSE(summary.is_complete());
}

TEST(CaptureSummary, IsNotCompleteWhereALidarDoesNotWorkAsTheRigFileSays) {
  CaptureSummary summary = two_lidars();
  summary.status.devices[0].report.link.missing_settings = {{"return_mode: dual", livox::Outcome::unsupported}};
  EXPECT_THAT(messages_of(summary),
              ElementsAre("avia: `return_mode: dual` is not in force (not known to the model or its firmware): update "
                          "its firmware, or change that in the rig file"));
  EXPECT_THAT(capture_text(summary), HasSubstr("avia: 30000 packets, 303 lost, `return_mode: dual` not in force\n"));
  const auto json = parse_json(capture_json(summary));
  EXPECT_TRUE(fits_schema("capture.json", json));
  EXPECT_EQ(json["sensors"][0]["missing_settings"], nlohmann::json({"return_mode: dual"}));
  EXPECT_EQ(capture_counters({}, {}, summary.status, {})["avia"]["missing_settings"], 1U);
}

TEST(CaptureSummary, CountsWhatWentWrongInTheTalkWithTheLidars) {
  CaptureSummary summary = two_lidars();
  livox::LinkCounters& link = summary.status.devices[0].report.link.counters;
  link.handshakes = 1;
  link.repeated = 2;
  link.stray_acks = 3;
  link.unreadable = 4;
  link.refused_heartbeats = 5;
  link.utc_taken = 6;
  link.utc_refused = 7;
  summary.control = {{8, 9}, 10, 11, 12, 13, 14};
  const auto json = parse_json(capture_json(summary));
  EXPECT_TRUE(fits_schema("capture.json", json));
  const auto of_avia = parse_json(R"({"handshakes": 1, "repeated_requests": 2, "stray_acks": 3,
      "unreadable_acks": 4, "refused_heartbeats": 5, "utc_taken": 6, "utc_refused": 7})");
  EXPECT_EQ(json["sensors"][0]["control"], of_avia);
  const auto kept = nlohmann::json(capture_counters({}, {}, summary.status, {})["avia"]);
  for (const auto& [name, count] : of_avia.items()) EXPECT_EQ(kept[name], count) << name;
  EXPECT_EQ(json["control"], parse_json(R"({"malformed": 8, "strangers": 9, "receive_errors": 10,
      "dropped_by_kernel": 11, "send_errors": 12, "unsent": 13, "lost_events": 14})"));
}

TEST(CaptureSummary, IsAsItsSchemaSays) {
  CaptureSummary summary = two_lidars();
  summary.gaps = {"2026-09-21 14:13:20.000 avia: lost: no heartbeat was answered for 3 s"};
  EXPECT_TRUE(fits_schema("capture.json", parse_json(capture_json(summary))));
  summary.forgotten_until_ns = noon_ns;
  EXPECT_TRUE(fits_schema("capture.json", parse_json(capture_json(summary))));
  EXPECT_THAT(capture_text(summary), HasSubstr("everything before 2026-09-21 14:13:20.000 UTC was thrown away"));
}

class Log : public testing::Test {
 protected:
  void tell(livox::EventContent content, std::size_t device = 0) {
    log.add(livox::Event{noon_ns, device, std::move(content)});
  }
  CaptureLog log{{"avia", "left"}};
};

TEST_F(Log, SaysWhatHappenedAndWhen) {
  tell(livox::Lost{livox::LossCause::silence});
  tell(livox::StatusChanged{0, 0x40006840}, 1);
  tell(livox::RequestEnded{livox::Command::coordinates, livox::Outcome::done, livox::RawControl{}});
  EXPECT_THAT(log.events(),
              ElementsAre("2026-09-21 14:13:20.000 avia: lost: no heartbeat was answered for 3 s",
                          "2026-09-21 14:13:20.000 left: status word 0x40006840 (was 0x00000000), window dirty or "
                          "blocked, fan warning"));
  EXPECT_THAT(log.gaps(), SizeIs(1));
}

TEST_F(Log, SaysWhichSettingIsNotInForceAndThatItIsAfterAll) {
  using livox::Outcome;
  tell(livox::RequestEnded{livox::Command::set_return_mode, Outcome::unsupported, livox::RawControl{}, ""});
  EXPECT_THAT(log.gaps(), IsEmpty());  // It is met all the same.
  tell(livox::RequestEnded{livox::Command::set_imu_rate, Outcome::unanswered, livox::RawControl{}, "imu: true"});
  tell(livox::RequestEnded{livox::Command::set_imu_rate, Outcome::done, livox::RawControl{}, "imu: true"});
  EXPECT_THAT(log.gaps(), ElementsAre(HasSubstr("avia: `imu: true` is not in force (not answered): ")));
  EXPECT_THAT(log.events(), SizeIs(3));
  EXPECT_EQ(log.events().back(), "2026-09-21 14:13:20.000 avia: `imu: true` is in force now");
}

TEST_F(Log, DoesNotSayTheSameAgainAndAgain) {
  for (int i = 0; i < 100; ++i) tell(livox::HandshakeRefused{});
  tell(livox::HandshakeUnanswered{});
  tell(livox::HandshakeRefused{});
  EXPECT_THAT(log.events(), SizeIs(3));
  EXPECT_THAT(log.gaps(), IsEmpty());
}

TEST_F(Log, IsInTheOrderOfItsTimes) {
  log.add(noon_ns + 420'000'000, "avia", "sampling stopped", true);
  log.add(noon_ns + 448'000'000, "capture", "stop 3 is over", false);
  log.add(noon_ns + 420'000'000, "left", "sampling stopped", true);
  log.add(noon_ns, "camera", "an image was lost", true);
  EXPECT_THAT(
      log.events(),
      ElementsAre("2026-09-21 14:13:20.000 camera: an image was lost", "2026-09-21 14:13:20.420 avia: sampling stopped",
                  "2026-09-21 14:13:20.420 left: sampling stopped", "2026-09-21 14:13:20.448 capture: stop 3 is over"));
  EXPECT_EQ(log.gaps().front(), "2026-09-21 14:13:20.000 camera: an image was lost");
  EXPECT_THAT(log.last_events(1), ElementsAre("2026-09-21 14:13:20.000 camera: an image was lost"));  // As it was told.
}

TEST_F(Log, IsBounded) {
  for (std::size_t i = 0; i < CaptureLog::kMost + 7; ++i) tell(livox::Lost{});
  EXPECT_THAT(log.gaps(), SizeIs(CaptureLog::kMost + 1));
  EXPECT_EQ(log.gaps().back(), "and 7 more");
}

TEST_F(Log, KnowsThatTheEndIsNoGap) {
  tell(livox::SamplingChanged{false});
  log.end();
  tell(livox::SamplingChanged{false});
  EXPECT_THAT(log.gaps(), SizeIs(1));
}

TEST_F(Log, TellsOnceOfALidarThatSendsNothingWithoutSayingThatItAnswers) {
  std::vector<livox::DeviceReport> devices(2);
  for (livox::DeviceReport& device : devices) {
    device.link.state = livox::LinkState::sampling;
    device.packets = 9;
    device.last_packet_ns = noon_ns;
  }
  log.compare(noon_ns + 1'900'000'000, devices);
  EXPECT_THAT(log.events(), IsEmpty());
  devices[0].last_packet_ns = noon_ns + 4'000'000'000;
  for (int i = 0; i < 3; ++i) log.compare(noon_ns + 5'000'000'000, devices);
  EXPECT_THAT(log.gaps(), ElementsAre("2026-09-21 14:13:25.000 left: no packet has come for 2 s"));
  devices[1].last_packet_ns = noon_ns + 5'900'000'000;
  log.compare(noon_ns + 6'000'000'000, devices);
  EXPECT_EQ(log.events().back(), "2026-09-21 14:13:26.000 left: packets come again");
  devices[1].link.state = livox::LinkState::preparing;  // Then it is known why.
  log.compare(noon_ns + 60'000'000'000, {devices[1], devices[1]});
  EXPECT_THAT(log.events(), SizeIs(2));
}

TEST_F(Log, TellsOfALidarThatSamplesAndOfWhichNothingEverCame) {
  std::vector<livox::DeviceReport> devices(2);
  devices[0].link.state = livox::LinkState::sampling;
  log.compare(noon_ns, devices);
  log.compare(noon_ns + 1'900'000'000, devices);
  EXPECT_THAT(log.events(), IsEmpty());
  for (int i = 0; i < 3; ++i) log.compare(noon_ns + 2'100'000'000, devices);
  EXPECT_THAT(log.gaps(),
              ElementsAre("2026-09-21 14:13:22.100 avia: it answers and was told to send, but no packet has "
                          "come in 2 s: let UDP through the firewall of this machine (rigcal doctor tells "
                          "how)"));
  devices[0].packets = 1;
  devices[0].last_packet_ns = noon_ns + 9'000'000'000;
  log.compare(noon_ns + 9'100'000'000, devices);
  EXPECT_EQ(log.events().back(), "2026-09-21 14:13:29.100 avia: packets come again");
}

TEST_F(Log, GivesALidarThatWasLostTimeToSendAgain) {
  std::vector<livox::DeviceReport> devices(2);
  devices[0].packets = 9;
  devices[0].last_packet_ns = noon_ns;
  devices[0].link.state = livox::LinkState::waiting;
  log.compare(noon_ns + 20'000'000'000, devices);
  devices[0].link.state = livox::LinkState::sampling;
  log.compare(noon_ns + 21'000'000'000, devices);
  log.compare(noon_ns + 22'900'000'000, devices);
  EXPECT_THAT(log.events(), IsEmpty());
  log.compare(noon_ns + 23'100'000'000, devices);
  EXPECT_THAT(log.gaps(), ElementsAre("2026-09-21 14:13:43.100 avia: no packet has come for 2 s"));
}

TEST_F(Log, TellsOfLossesInThisMachineAsTheyGrow) {
  auto interfaces = two_lidars().interfaces;
  log.compare(noon_ns, interfaces);
  interfaces[0].counters.dropped_by_kernel = 40;
  log.compare(noon_ns, interfaces);
  log.compare(noon_ns, interfaces);
  interfaces[0].counters.dropped_by_kernel = 42;
  interfaces[0].counters.dropped_by_queue = 3;
  log.compare(noon_ns, interfaces);
  EXPECT_THAT(log.gaps(),
              ElementsAre("2026-09-21 14:13:20.000 eth0 192.168.1.5: 40 packets were lost, because the socket's buffer "
                          "of 208 KiB was full",
                          "2026-09-21 14:13:20.000 eth0 192.168.1.5: 2 packets were lost, because the socket's buffer "
                          "of 208 KiB was full",
                          "2026-09-21 14:13:20.000 eth0 192.168.1.5: 3 packets were lost, because this program or its "
                          "disk was too slow"));
}

}  // namespace
}  // namespace rigcal
