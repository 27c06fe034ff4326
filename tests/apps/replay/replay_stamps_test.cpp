// What is read of a recording before it is played, and how its packets become those of devices that run now.
#include "apps/replay/replay_stamps.h"

#include <gtest/gtest.h>

#include <cmath>

#include "apps/replay/recorded_devices.h"
#include "core/base/random.h"
#include "drivers/livox_codec/control_payload.h"

namespace rigcal {
namespace {

using namespace livox;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t second = 1000 * ms;

std::vector<std::uint8_t> packet_of(TimestampType type, std::int64_t stamp_ns, DataType data = DataType::cartesian) {
  std::vector<std::uint8_t> bytes;
  SampleHeader header;
  header.status = 0x40006840;
  header.timestamp_type = type;
  header.data_type = data;
  header.device_stamp_ns = stamp_ns;
  if (data == DataType::imu) {
    encode_imu(header, {{0.1F, -0.2F, 0.3F}, {0.0F, 0.0F, 1.0F}}, bytes);
  } else {
    const std::vector<Point> points{{1.0F, 2.0F, 3.0F, 40, 16, 0}, {10.0F, -4.0F, 0.5F, 9, 32, 29}};
    encode_points(header, points, bytes);
  }
  return bytes;
}

std::int64_t stamp_of(const std::vector<std::uint8_t>& packet) {
  const auto parsed = parse_sample_packet(packet);
  EXPECT_TRUE(parsed.has_value());
  return parsed ? parsed->header.device_stamp_ns : -1;
}

TEST(ReplayStamps, LeaveTheFirstPassAtItsPaceAsItIs) {
  for (const TimestampType type :
       {TimestampType::since_start, TimestampType::ptp, TimestampType::gps, TimestampType::pps_only}) {
    ReplayStamps stamps;
    for (std::int64_t k = 0; k < 3; ++k) {
      const auto recorded = packet_of(type, 1'600'000'000 * second + k * 123'456'000);
      auto packet = recorded;
      stamps.rewrite({}, k * 123'456'000, packet);
      EXPECT_TRUE(packet == recorded);
    }
    auto noise = std::vector<std::uint8_t>(40, 5);
    stamps.rewrite({2.0, 5}, 0, noise);
    EXPECT_TRUE(noise == std::vector<std::uint8_t>(40, 5));
  }
}

TEST(ReplayStamps, RunFasterWithTheirClock) {
  for (const TimestampType type : {TimestampType::since_start, TimestampType::ptp, TimestampType::gps}) {
    ReplayStamps stamps;
    const std::int64_t start = 1'600'000'000 * second;
    auto first = packet_of(type, start);
    stamps.rewrite({4.0, 0}, 0, first);
    EXPECT_EQ(stamp_of(first), start);
    auto later = packet_of(type, start + 10 * second);
    stamps.rewrite({4.0, 0}, 10 * second, later);
    EXPECT_EQ(stamp_of(later), start + 2500 * ms);
    // The second pass goes on where the first ended.
    auto again = packet_of(type, start);
    stamps.rewrite({4.0, 20 * second}, 0, again);
    EXPECT_EQ(stamp_of(again), start + 5 * second);
  }
}

TEST(ReplayStamps, CountFromPulsesASecondApartAtAnySpeed) {
  ReplayStamps stamps;
  for (int k = 0; k < 40; ++k) {
    const std::int64_t since_first = k * 300 * ms;
    auto packet = packet_of(TimestampType::pps_only, (500 * ms + since_first) % second);
    stamps.rewrite({2.0, 0}, since_first + (k % 3) * ms, packet);  // What comes late is of its time all the same.
    EXPECT_EQ(stamp_of(packet), (500 * ms + since_first / 2) % second) << k;
  }
}

TEST(ReplayStamps, BeginAnewWithTheDeviceAndTurnTheGyro) {
  ReplayStamps stamps;
  auto packet = packet_of(TimestampType::since_start, 100 * second);
  stamps.rewrite({}, 0, packet);
  stamps.restart(7 * ms);
  packet = packet_of(TimestampType::since_start, 101 * second);
  stamps.rewrite({}, second, packet);
  EXPECT_EQ(stamp_of(packet), 7 * ms);
  packet = packet_of(TimestampType::since_start, 103 * second, DataType::imu);
  stamps.rewrite({2.0, 0}, 3 * second, packet);
  const auto parsed = parse_sample_packet(packet);
  ASSERT_TRUE(parsed.has_value());
  EXPECT_FLOAT_EQ(decode_imu(*parsed)->gyro_rad_s[2], 0.6F);
  EXPECT_FLOAT_EQ(decode_imu(*parsed)->acceleration_g[2], 1.0F);
  EXPECT_EQ(parsed->header.status, 0x40006840U);
}

TEST(ReplayStamps, ChangeCoordinatesWithinTheirRounding) {
  for (const DataType type :
       {DataType::cartesian, DataType::cartesian_tagged, DataType::dual_cartesian, DataType::triple_cartesian}) {
    const auto recorded = packet_of(TimestampType::ptp, 5 * second, type);
    auto packet = recorded;
    change_coordinates(false, packet);
    EXPECT_TRUE(packet == recorded);
    change_coordinates(true, packet);
    const auto spherical = parse_sample_packet(packet);
    ASSERT_TRUE(spherical.has_value());
    EXPECT_TRUE(record_layout(spherical->header.data_type).spherical);
    EXPECT_EQ(spherical->header.device_stamp_ns, 5 * second);
    std::vector<Point> points;
    decode_points(*spherical, points);
    ASSERT_EQ(points.size(), 2U);
    EXPECT_EQ(points[1].shot, 29);
    EXPECT_EQ(points[1].reflectivity, 9);
    EXPECT_NEAR(points[1].x, 10.0, 0.002);  // 0.005 degrees at 11 m, and half a millimetre.
    EXPECT_NEAR(points[1].y, -4.0, 0.002);
    change_coordinates(false, packet);
    EXPECT_EQ(parse_sample_packet(packet)->header.data_type, type);
  }
}

TEST(ReplayStamps, MakeAPacketOfAPacketWhateverItsStampAndPointsAre) {
  Random random(5);
  ReplayStamps stamps;
  int packets = 0;
  for (int k = 0; k < 2000; ++k) {
    auto packet = packet_of(TimestampType::since_start, 0, static_cast<DataType>(random.below(9)));
    for (std::size_t i = 10; i < packet.size(); ++i) packet[i] = static_cast<std::uint8_t>(random.below(256));
    constexpr std::uint8_t types[] = {0, 1, 3, 4};
    packet[8] = types[random.below(4)];
    if (random.below(9) == 0) stamps.restart(static_cast<std::int64_t>(random.below(1000)));
    const std::size_t size = packet.size();
    const bool is_packet = parse_sample_packet(packet).has_value();
    packets += is_packet ? 1 : 0;
    stamps.rewrite({random.uniform(0.01, 100.0), static_cast<std::int64_t>(random.below(1ULL << 62U))},
                   static_cast<std::int64_t>(random.below(1ULL << 62U)), packet);
    ASSERT_EQ(packet.size(), size) << k;
    ASSERT_EQ(parse_sample_packet(packet).has_value(), is_packet) << k;
    const bool spherical = random.below(2) == 0;
    change_coordinates(spherical, packet);
    const auto changed = parse_sample_packet(packet);
    ASSERT_EQ(changed.has_value(), is_packet) << k;
    if (!changed || changed->header.data_type == DataType::imu) continue;
    ASSERT_EQ(record_layout(changed->header.data_type).spherical, spherical) << k;
  }
  EXPECT_GT(packets, 500);
}

struct Said {
  Endpoint from;
  std::vector<std::uint8_t> bytes;
};

bool add(RecordedDevices& devices, const Said& said, std::int64_t stamp_ns = 0) {
  return devices.add({stamp_ns, said.from, {{192, 168, 1, 5}, 56001}, said.bytes});
}

const Endpoint avia_points{{192, 168, 1, 179}, kPointSourcePort};
const Endpoint avia_control{{192, 168, 1, 179}, kDevicePort};
const Endpoint host{{192, 168, 1, 5}, 55501};

TEST(RecordedDevices, KnowWhatALidarHasSent) {
  RecordedDevices devices;
  EXPECT_FALSE(add(devices, {avia_points, {1, 2, 3}}));  // Nobody has spoken from there yet.
  EXPECT_FALSE(add(devices, {host, encode_control(HeartbeatRequest{}, 1)}));
  EXPECT_FALSE(add(devices, {host, make_handshake({{192, 168, 1, 5}, 56001, 55501, {}}, 2, FrameType::ack)}));
  const Broadcast avia{"3JEDK380010Z391", DeviceType::avia, kDevicePort};
  EXPECT_TRUE(add(devices, {avia_control, make_broadcast(avia, 1)}, 10));
  EXPECT_TRUE(
      add(devices, {avia_control, encode_control(DeviceInformationAck{ReturnCode::success, {11, 9, 0, 1}}, 2)}, 11));
  EXPECT_TRUE(add(devices, {avia_points, packet_of(TimestampType::ptp, 3, DataType::dual_cartesian)}, 12));
  EXPECT_TRUE(add(devices, {avia_points, packet_of(TimestampType::ptp, 3, DataType::imu)}, 13));
  EXPECT_TRUE(add(devices, {avia_points, {1, 2, 3}}, 14));  // A damaged one.
  const RecordedDevice& device = devices.devices().at(avia_points.ip);
  EXPECT_EQ(device.broadcast, avia);
  EXPECT_EQ(device.firmware, (FirmwareVersion{11, 9, 0, 1}));
  EXPECT_EQ(device.points, DataType::dual_cartesian);
  EXPECT_EQ(device.point_packets, 1U);
  EXPECT_EQ(device.imu_packets, 1U);
  EXPECT_EQ(device.first_status, 0x40006840U);
  EXPECT_EQ(device.ports, (std::set<std::uint16_t>{kPointSourcePort, kDevicePort}));
  EXPECT_EQ(devices.first_sample_ns(), 12);
}

TEST(RecordedDevices, AreBounded) {
  RecordedDevices devices;
  for (int k = 0; k < 200; ++k) {
    const Endpoint from{{10, 0, static_cast<std::uint8_t>(k / 100), static_cast<std::uint8_t>(k % 100)}, 60001};
    EXPECT_EQ(add(devices, {from, packet_of(TimestampType::ptp, 3)}), k < 64);
  }
  EXPECT_TRUE(devices.has_overflowed());
  EXPECT_EQ(devices.devices().size(), RecordedDevices::kMost);
}

TEST(RecordedDevices, AreWhatTheySayOrTheRigFileSaysOrTheirPacketsLookLike) {
  RecordedDevice device;
  device.ip = {192, 168, 1, 21};
  device.points = DataType::spherical;
  Rig rig;
  DeviceIdentity identity = identity_of(device, rig);
  EXPECT_TRUE(identity.is_guessed);
  EXPECT_EQ(identity.broadcast.type, DeviceType::mid40);
  EXPECT_EQ(identity.broadcast.broadcast_code, "0TFDSIM00000211");
  device.points = DataType::triple_cartesian;
  EXPECT_EQ(identity_of(device, rig).broadcast.type, DeviceType::avia);
  Sensor sensor;
  sensor.name = "tele";
  sensor.lidar.emplace();
  sensor.lidar->model = LidarModel::livox_tele15;
  sensor.lidar->ip = device.ip;
  rig.sensors.push_back(sensor);
  identity = identity_of(device, rig);
  EXPECT_FALSE(identity.is_guessed);
  EXPECT_EQ(identity.broadcast.broadcast_code, "1PQDSIM00000211");
  rig.sensors[0].lidar->broadcast_code = "1PQDH5B00100041";
  EXPECT_EQ(identity_of(device, rig).broadcast.broadcast_code, "1PQDH5B00100041");
  device.broadcast = Broadcast{"3GGDJ6K00100111", DeviceType::mid70, 0};
  EXPECT_EQ(identity_of(device, rig).broadcast, *device.broadcast);
}

}  // namespace
}  // namespace rigcal
