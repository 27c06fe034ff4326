#include "apps/ingest/lidar_ingest.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "drivers/livox_codec/control_payload.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr IpAddress kAviaIp{192, 168, 1, 179};
constexpr IpAddress kLeftIp{192, 168, 1, 21};
constexpr IpAddress kRightIp{192, 168, 1, 161};
constexpr IpAddress kStrangerIp{192, 168, 1, 99};
constexpr IpAddress kHostIp{192, 168, 1, 5};
const std::string kAviaCode = "3JEDHC900100791";
const std::string kLeftCode = "0TFDG3B00600551";
const std::string kRightCode = "0TFDG3B00600553";
constexpr std::int64_t kStart = 1'700'000'000'000'000'000;

Sensor make_lidar(const std::string& name, LidarModel model, std::optional<IpAddress> ip, const std::string& code) {
  Sensor sensor;
  sensor.name = name;
  sensor.lidar.emplace();
  sensor.lidar->model = model;
  sensor.lidar->ip = ip;
  sensor.lidar->broadcast_code = code;
  return sensor;
}

Rig make_rig() {
  Rig rig;
  rig.sensors = {make_lidar("avia", LidarModel::livox_avia, kAviaIp, kAviaCode),
                 make_lidar("left", LidarModel::livox_mid40, kLeftIp, kLeftCode),
                 make_lidar("right", LidarModel::livox_mid40, kRightIp, kRightCode)};
  rig.sensors.emplace_back().name = "camera";
  rig.sensors.back().camera.emplace();
  return rig;
}

/// Sends datagrams to a LidarIngest and keeps what comes out.
class Bench {
 public:
  explicit Bench(const Rig& rig, const BroadcastCodes& codes = {})
      : ingest(
            rig, [this](PointBatch& batch) { batches.push_back(batch); },
            [this](const ImuSample& sample) { imu.push_back(sample); }, codes) {}

  void send(const IpAddress& from, const std::vector<std::uint8_t>& bytes, std::int64_t at_ns = 0) {
    ingest.add({kStart + at_ns, {from, 60001}, {kHostIp, 56001}, bytes});
  }
  void ask(const IpAddress& device, const std::vector<std::uint8_t>& bytes) {
    ingest.add({kStart, {kHostIp, 55501}, {device, livox::kDevicePort}, bytes});
  }
  void send_points(const IpAddress& from, livox::DataType type, std::int64_t device_ns,
                   const std::vector<Point>& points = {{10.0F, 0.0F, 0.0F, 50, 0, 3}}) {
    livox::SampleHeader header;
    header.data_type = type;
    header.device_stamp_ns = device_ns;
    std::vector<std::uint8_t> bytes;
    livox::encode_points(header, points, bytes);
    send(from, bytes, device_ns);
  }
  void send_one_of_each() {
    send_points(kAviaIp, livox::DataType::cartesian_tagged, 0);
    send_points(kLeftIp, livox::DataType::cartesian, 0);
    send_points(kRightIp, livox::DataType::spherical, 0);
  }
  void broadcast(const IpAddress& from, const std::string& code, livox::DeviceType type = livox::DeviceType::mid40) {
    send(from, livox::make_broadcast({code, type, 0}, 1));
  }

  std::vector<PointBatch> batches;
  std::vector<ImuSample> imu;
  LidarIngest ingest;
};

TEST(LidarIngest, GivesEachSensorItsPointsWithTheirTime) {
  Bench bench(make_rig());
  bench.send_one_of_each();
  ASSERT_THAT(bench.batches, SizeIs(3));
  EXPECT_EQ(bench.batches[0].sensor, 0);
  EXPECT_EQ(bench.batches[1].sensor, 1);
  EXPECT_EQ(bench.batches[2].sensor, 2);
  EXPECT_EQ(bench.batches[0].stamp_ns, kStart);
  EXPECT_EQ(bench.batches[0].shots, 96);
  EXPECT_NEAR(bench.batches[0].shot_interval_ns, 4166.6667, 1e-3);
  EXPECT_EQ(bench.batches[1].shots, 100);
  EXPECT_EQ(bench.batches[1].shot_interval_ns, 10000.0);
  ASSERT_THAT(bench.batches[1].points, SizeIs(1));
  EXPECT_FLOAT_EQ(bench.batches[1].points[0].x, 10.0F);
  EXPECT_EQ(bench.batches[1].points[0].shot, 3);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_THAT(summary->warnings, IsEmpty());
  ASSERT_NE(summary->of_sensor(1), nullptr);
  EXPECT_EQ(summary->of_sensor(1)->points, 1U);
}

TEST(LidarIngest, AMid70ShootsATenthOfAMillisecondApartForTenShots) {
  Rig rig = make_rig();
  rig.sensors[0].lidar->model = LidarModel::livox_mid70;
  Bench bench(rig);
  bench.send_points(kAviaIp, livox::DataType::cartesian_tagged, 0);
  EXPECT_EQ(bench.batches.at(0).shot_interval_ns, 10000.0);
}

TEST(LidarIngest, LeavesOutNoiseAndPointsOutOfRangeAndCountsThem) {
  Rig rig = make_rig();
  rig.sensors[1].lidar->range_m = {3.0, 20.0};
  Bench bench(rig);
  bench.send_points(kAviaIp, livox::DataType::cartesian_tagged, 0,
                    {{10.0F, 0.0F, 0.0F, 1, 0x10, 0},     // Good.
                     {10.0F, 0.0F, 0.0F, 2, 0x11, 1},     // Spatial noise, high confidence.
                     {10.0F, 0.0F, 0.0F, 3, 0x18, 2},     // Intensity noise, moderate.
                     {10.0F, 0.0F, 0.0F, 4, 0x13, 3},     // Low confidence: kept.
                     {1.0F, 0.5F, 0.5F, 5, 0x10, 4},      // Nearer than 1.5 m.
                     {150.0F, 150.0F, 0.0F, 6, 0x10, 5},  // Farther than 200 m.
                     {1.0F, 0.0F, 0.0F, 7, 0x11, 6}});    // Noise and near: counted once, as noise.
  bench.send_points(kLeftIp, livox::DataType::cartesian, 0,
                    {{2.0F, 0.0F, 0.0F, 8, 0, 0}, {25.0F, 0.0F, 0.0F, 9, 0, 1}, {15.0F, 0.0F, 0.0F, 10, 0, 2}});
  ASSERT_THAT(bench.batches.at(0).points, SizeIs(2));
  EXPECT_EQ(bench.batches[0].points[0].reflectivity, 1);
  EXPECT_EQ(bench.batches[0].points[1].reflectivity, 4);
  ASSERT_THAT(bench.batches.at(1).points, SizeIs(1));
  EXPECT_EQ(bench.batches[1].points[0].reflectivity, 10);
  const IngestSummary summary = bench.ingest.summary();
  EXPECT_EQ(summary.of_sensor(0)->noise, 3U);
  EXPECT_EQ(summary.of_sensor(0)->out_of_range, 2U);
  EXPECT_EQ(summary.of_sensor(0)->points, 2U);
  EXPECT_EQ(summary.of_sensor(1)->out_of_range, 2U);
}

TEST(LidarIngest, TakesEveryEchoOnce) {
  Bench bench(make_rig());
  bench.send_points(kAviaIp, livox::DataType::triple_cartesian, 0,
                    {{10.0F, 0.0F, 0.0F, 50, 0x10, 0},  // Two echoes, the third slot is empty.
                     {20.0F, 0.0F, 0.0F, 40, 0x20, 0},
                     {10.0F, 0.0F, 0.0F, 50, 0x10, 1},  // The device filled up with its only one.
                     {10.0F, 0.0F, 0.0F, 50, 0x20, 1},
                     {10.0F, 0.0F, 0.0F, 50, 0x30, 1},
                     {10.0F, 0.0F, 0.0F, 50, 0x10, 2}});  // The same place as the shot before: a point of its own.
  bench.send_points(kLeftIp, livox::DataType::cartesian, 0,
                    {{10.0F, 0.0F, 0.0F, 1, 0, 0}, {10.0F, 0.0F, 0.0F, 1, 0, 1}});
  ASSERT_THAT(bench.batches, SizeIs(2));
  ASSERT_THAT(bench.batches[0].points, SizeIs(4));
  EXPECT_EQ(bench.batches[0].points[1].x, 20.0F);
  EXPECT_EQ(bench.batches[0].points[3].shot, 2);
  EXPECT_THAT(bench.batches[1].points, SizeIs(2));
  EXPECT_EQ(bench.ingest.summary().of_sensor(0)->repeated, 2U);
}

TEST(LidarIngest, PassesTheImuOn) {
  Bench bench(make_rig());
  livox::SampleHeader header;
  header.data_type = livox::DataType::imu;
  std::vector<std::uint8_t> bytes;
  livox::encode_imu(header, {{0.1F, 0.2F, 0.3F}, {0.0F, 0.0F, 1.0F}}, bytes);
  bench.send(kAviaIp, bytes);
  livox::encode_imu(header, {{NAN, 0.2F, 0.3F}, {0.0F, 0.0F, 1.0F}}, bytes);
  header.device_stamp_ns = 5'000'000;
  bench.send(kAviaIp, bytes, 5'000'000);
  ASSERT_THAT(bench.imu, SizeIs(1));
  EXPECT_EQ(bench.imu[0].sensor, 0);
  EXPECT_FLOAT_EQ(static_cast<float>(bench.imu[0].gyro_rad_s.y()), 0.2F);
  EXPECT_EQ(bench.imu[0].acceleration_g.z(), 1.0);
}

TEST(LidarIngest, CountsLossAndLeavesDuplicatesOut) {
  Bench bench(make_rig());
  bench.send_one_of_each();
  for (const int i : {1, 2, 2, 5, 6}) bench.send_points(kLeftIp, livox::DataType::cartesian, i * 1'000'000);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary);
  const DeviceIngest& left = *summary->of_sensor(1);
  EXPECT_EQ(left.point_stream.lost, 2U);
  EXPECT_EQ(left.point_stream.duplicated, 1U);
  EXPECT_EQ(left.unused_packets, 1U);
  EXPECT_EQ(left.point_stream.expected(), 7U);
  EXPECT_THAT(bench.batches, SizeIs(7));
  ASSERT_THAT(summary->warnings, SizeIs(1));
  EXPECT_THAT(summary->warnings[0], HasSubstr("left"));
  EXPECT_THAT(summary->warnings[0], HasSubstr("2 in 1 gap)"));
}

TEST(LidarIngest, CountsTheTimeFromThePulseOn) {
  Bench bench(make_rig());
  for (std::int64_t i = 0; i < 4000; ++i) {
    livox::SampleHeader header;
    header.timestamp_type = livox::TimestampType::pps_only;
    const std::int64_t since = 300'000'000 + i * 1'000'000;
    header.device_stamp_ns = since % 1'000'000'000;
    std::vector<std::uint8_t> bytes;
    livox::encode_points(header, {}, bytes);
    bench.send(kLeftIp, bytes, since);
  }
  ASSERT_THAT(bench.batches, SizeIs(4000));
  EXPECT_EQ(bench.batches.back().stamp_ns, kStart + 300'000'000 + 3999 * 1'000'000LL);
  EXPECT_EQ(bench.ingest.summary().of_sensor(1)->point_stream.lost, 0U);
  EXPECT_EQ(bench.ingest.summary().of_sensor(1)->clock.jumps, 0U);
}

TEST(LidarIngest, CountsTheControlFramesOfEachDeviceInBothDirections) {
  Bench bench(make_rig());
  bench.broadcast(kLeftIp, kLeftCode);
  const livox::Handshake handshake{kHostIp, 56001, 55501, {}};
  bench.ask(kLeftIp, livox::make_handshake(handshake, 1, livox::FrameType::ack));  // As the vendor's software asks.
  bench.send(kLeftIp, livox::encode_control(livox::HandshakeAck{}, 1));
  for (std::uint16_t seq = 2; seq < 5; ++seq) {
    bench.ask(kLeftIp, livox::encode_control(livox::HeartbeatRequest{}, seq));
    bench.send(kLeftIp, livox::encode_control(livox::HeartbeatAck{}, seq));
  }
  bench.send(kRightIp, livox::encode_control(livox::AbnormalStatus{}, 0));
  bench.ask(kStrangerIp, livox::encode_control(livox::HeartbeatRequest{}, 5));  // Nobody answers: no device.
  bench.send_one_of_each();
  const IngestSummary summary = bench.ingest.summary();
  EXPECT_EQ(summary.control_frames, 11U);
  EXPECT_THAT(summary.devices, SizeIs(3));
  using Counts = std::map<std::string, std::uint64_t>;
  EXPECT_EQ(summary.of_sensor(0)->control_frames, Counts{});
  EXPECT_EQ(summary.of_sensor(1)->control_frames,
            (Counts{{"broadcast", 1}, {"handshake", 1}, {"handshake_ack", 1}, {"heartbeat", 3}, {"heartbeat_ack", 3}}));
  EXPECT_EQ(summary.of_sensor(2)->control_frames, (Counts{{"abnormal_status", 1}}));
}

TEST(LidarIngest, TheBroadcastCodeCountsMoreThanTheAddress) {
  Bench bench(make_rig());
  bench.broadcast(kLeftIp, kRightCode);
  bench.broadcast(kRightIp, kLeftCode);
  bench.send_one_of_each();
  EXPECT_EQ(bench.batches.at(1).sensor, 2);
  EXPECT_EQ(bench.batches.at(2).sensor, 1);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary) << summary.error().message();
  ASSERT_THAT(summary->warnings, SizeIs(2));
  EXPECT_THAT(summary->warnings[0], HasSubstr("192.168.1.21"));
  EXPECT_THAT(summary->warnings[0], HasSubstr("it is used as right"));
}

TEST(LidarIngest, FindsASensorThatHasMovedToAnotherAddress) {
  Bench bench(make_rig());
  bench.broadcast(kStrangerIp, kLeftCode);
  bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
  bench.send_points(kLeftIp, livox::DataType::cartesian, 0);  // Another device now; not the sensor.
  ASSERT_THAT(bench.batches, SizeIs(1));
  EXPECT_EQ(bench.batches[0].sensor, 1);
}

TEST(LidarIngest, ASensorWithoutAddressIsFoundByItsBroadcast) {
  Rig rig = make_rig();
  rig.sensors[1].lidar->ip.reset();
  Bench bench(rig);
  bench.broadcast(kStrangerIp, kLeftCode);
  bench.send_points(kAviaIp, livox::DataType::cartesian_tagged, 0);
  bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
  bench.send_points(kRightIp, livox::DataType::cartesian, 0);
  EXPECT_TRUE(bench.ingest.finish());
  EXPECT_THAT(bench.batches, SizeIs(3));
}

TEST(LidarIngest, ABroadcastAfterThePointsAsksForASecondReading) {
  Bench first(make_rig());
  first.send_one_of_each();
  EXPECT_FALSE(first.ingest.learned_too_late());
  first.broadcast(kLeftIp, kRightCode);
  EXPECT_TRUE(first.ingest.learned_too_late());
  EXPECT_FALSE(first.ingest.finish());
  first.broadcast(kRightIp, kLeftCode);
  Bench second(make_rig(), first.ingest.codes());
  second.send_one_of_each();
  second.broadcast(kLeftIp, kRightCode);
  EXPECT_FALSE(second.ingest.learned_too_late());
  EXPECT_EQ(second.batches.at(1).sensor, 2);
}

TEST(LidarIngest, LearningBeforehandNeedsOneReadingOnly) {
  Bench bench(make_rig());
  const auto bytes = livox::make_broadcast({kRightCode, livox::DeviceType::mid40, 0}, 1);
  bench.ingest.learn({0, {kLeftIp, 65000}, {kHostIp, 55000}, bytes});
  bench.send_points(kLeftIp, livox::DataType::cartesian, 0);
  EXPECT_EQ(bench.batches.at(0).sensor, 2);
}

TEST(LidarIngest, AStrangerIsNamedAndNotUsed) {
  Bench bench(make_rig());
  bench.send_one_of_each();
  bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
  EXPECT_THAT(bench.batches, SizeIs(3));
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary);
  ASSERT_THAT(summary->warnings, SizeIs(1));
  EXPECT_THAT(summary->warnings[0], HasSubstr("192.168.1.99"));
}

TEST(LidarIngest, WarnsOfAnotherModelDamagedPacketsAndAStatus) {
  Bench bench(make_rig());
  bench.broadcast(kAviaIp, kAviaCode, livox::DeviceType::horizon);
  bench.send_one_of_each();
  bench.send(kLeftIp, {5, 1, 1});
  livox::SampleHeader header;
  header.status = 0x40006840;
  header.device_stamp_ns = 1'000'000;
  std::vector<std::uint8_t> bytes;
  livox::encode_points(header, {}, bytes);
  bench.send(kRightIp, bytes, 1'000'000);
  const IngestSummary summary = bench.ingest.summary();
  ASSERT_THAT(summary.warnings, SizeIs(3));
  EXPECT_THAT(summary.warnings[0], HasSubstr("damaged"));
  EXPECT_THAT(summary.warnings[1], HasSubstr("0x40006840"));
  EXPECT_THAT(summary.warnings[2], HasSubstr("Horizon"));
}

TEST(LidarIngest, ADumpWithoutALivoxPacketIsAnError) {
  Bench bench(make_rig());
  bench.send(kStrangerIp, {1, 2, 3});
  bench.send(kStrangerIp, {});
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().message(), HasSubstr("no Livox packet"));
  EXPECT_EQ(summary.error().kind, ErrorKind::input);
  EXPECT_EQ(bench.ingest.summary().not_livox, 2U);
}

TEST(LidarIngest, TwoDevicesThatSayTheyAreOneSensorAreWarnedOf) {
  Bench bench(make_rig());
  bench.broadcast(kLeftIp, kLeftCode);
  bench.broadcast(kStrangerIp, kLeftCode);
  bench.send_one_of_each();
  bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary);
  EXPECT_EQ(summary->of_sensor(1)->ip, kLeftIp);
  ASSERT_THAT(summary->warnings, SizeIs(1));
  EXPECT_THAT(summary->warnings[0], HasSubstr("both 192.168.1.21 and 192.168.1.99"));
}

TEST(LidarIngest, LidarsBehindAHubAreNotTakenForOne) {
  Bench bench(make_rig());
  bench.send_one_of_each();
  const auto send = [&](std::uint8_t slot, std::int64_t device_ns) {
    livox::SampleHeader header;
    header.slot = slot;
    header.device_stamp_ns = device_ns;
    std::vector<std::uint8_t> bytes;
    livox::encode_points(header, {{{10.0F, 0.0F, 0.0F, 50, 0, 3}}}, bytes);
    bench.send(kLeftIp, bytes, device_ns);
  };
  for (int i = 1; i < 300; ++i) send(i == 40 ? 7 : 1, 1'000'000 * i);
  EXPECT_TRUE(bench.ingest.finish()) << "one damaged number is none";
  for (int i = 300; i < 600; ++i) send(i % 3 == 0 ? 2 : 1, 1'000'000 * i);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_FALSE(summary);
  EXPECT_THAT(summary.error().message(), HasSubstr("several LiDARs send from 192.168.1.21"));
  EXPECT_THAT(summary.error().message(), HasSubstr("left is one"));
  EXPECT_TRUE(bench.ingest.summary().unfit);
}

TEST(LidarIngest, WithoutALidarThatSentNothingTheOthersAreUsed) {
  Bench bench(make_rig());
  bench.send_points(kAviaIp, livox::DataType::cartesian_tagged, 0);
  bench.send_points(kLeftIp, livox::DataType::cartesian, 0);
  bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_FALSE(summary->unfit);
  EXPECT_THAT(summary->warnings,
              Contains(AllOf(HasSubstr("no points of right (192.168.1.161"), HasSubstr("avia (192.168.1.179)"),
                             HasSubstr("192.168.1.99"), HasSubstr("correct ip or broadcast_code"))));
}

TEST(LidarIngest, WithoutTheBaseOrWithTheBaseAloneIsAnErrorThatSaysWhatItHas) {
  Rig without_cameras = make_rig();
  without_cameras.sensors.pop_back();
  for (const auto& [rig, ip] : {std::pair{make_rig(), kLeftIp}, std::pair{without_cameras, kAviaIp}}) {
    Bench bench(rig);
    bench.send_points(ip, livox::DataType::cartesian, 0);
    bench.send_points(kStrangerIp, livox::DataType::cartesian, 0);
    const Expected<IngestSummary> refused = bench.ingest.finish();
    ASSERT_FALSE(refused);
    EXPECT_THAT(refused.error().message(), AllOf(HasSubstr("right (192.168.1.161"), HasSubstr(to_string(ip)),
                                                 HasSubstr("192.168.1.99"), HasSubstr("correct ip")));
    EXPECT_TRUE(bench.ingest.summary().unfit);
  }
}

TEST(LidarIngest, WithoutARigEveryDeviceIsListedWithItsPoints) {
  Bench bench(Rig{});
  bench.send_one_of_each();
  bench.broadcast(kLeftIp, kLeftCode);
  const Expected<IngestSummary> summary = bench.ingest.finish();
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_THAT(summary->devices, SizeIs(3));
  for (const DeviceIngest& device : summary->devices) EXPECT_EQ(device.points, 1U);
  EXPECT_THAT(bench.batches, IsEmpty());
}

TEST(LidarIngest, MemoryIsBoundedWhateverAddressesCome) {
  Bench bench(make_rig());
  for (std::uint8_t a = 0; a < 10; ++a) {
    for (int b = 0; b < 256; ++b) {
      bench.send_points({10, 0, a, static_cast<std::uint8_t>(b)}, livox::DataType::cartesian, 0);
      bench.broadcast({10, 1, a, static_cast<std::uint8_t>(b)}, kLeftCode);
    }
  }
  bench.send_points(kAviaIp, livox::DataType::cartesian_tagged, 0);
  EXPECT_EQ(bench.batches.back().sensor, 0);
  EXPECT_LE(bench.ingest.summary().devices.size(), 515U);  // 256 by packets, 256 by broadcasts, and the rig.
}

}  // namespace
}  // namespace rigcal
