#include "drivers/livox_codec/sample_packet.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.h"
#include "tests/support/hex.h"

namespace rigcal::livox {
namespace {

constexpr std::array kPointTypes{DataType::cartesian,        DataType::spherical,       DataType::cartesian_tagged,
                                 DataType::spherical_tagged, DataType::dual_cartesian,  DataType::dual_spherical,
                                 DataType::triple_cartesian, DataType::triple_spherical};
constexpr std::array kTimestampTypes{TimestampType::since_start, TimestampType::ptp, TimestampType::gps,
                                     TimestampType::pps_only};

/// A worked example shows the start of a packet; the slots behind it are zeros here.
std::vector<std::uint8_t> full_packet(const std::string& hex) {
  std::vector<std::uint8_t> bytes = from_hex(hex);
  bytes.resize(packet_bytes(static_cast<DataType>(bytes.at(9))), 0);
  return bytes;
}

struct Decoded {
  SampleHeader header;
  std::vector<Point> points;
};

Decoded decode(const std::vector<std::uint8_t>& bytes) {
  const Expected<SamplePacket> packet = parse_sample_packet(bytes);
  EXPECT_TRUE(packet) << packet.error().message();
  Decoded decoded{packet->header, {}};
  decode_points(*packet, decoded.points);
  return decoded;
}

void expect_point(const Point& point, double x, double y, double z, double tolerance) {
  EXPECT_NEAR(point.x, x, tolerance);
  EXPECT_NEAR(point.y, y, tolerance);
  EXPECT_NEAR(point.z, z, tolerance);
}

// A float of up to 32 m is good to 2 micrometres.
constexpr double kFloat = 2e-6;

TEST(SamplePacket, SizesAreThoseOfTheProtocol) {
  const std::array<std::size_t, 9> sizes{1318, 918, 1362, 978, 1362, 786, 42, 1278, 678};
  for (std::size_t type = 0; type < sizes.size(); ++type) {
    EXPECT_EQ(packet_bytes(static_cast<DataType>(type)), sizes[type]) << type;
  }
}

TEST(SamplePacket, ReadsTheCartesianExample) {
  const auto bytes =
      full_packet("05010100000000000000cb04fb711f0100001027000006ffffffdc0500002500000000000000000000000000");
  const Decoded decoded = decode(bytes);
  EXPECT_EQ(decoded.header.timestamp_type, TimestampType::since_start);
  EXPECT_EQ(decoded.header.device_stamp_ns, 1234567890123);
  EXPECT_EQ(decoded.header.slot, 1);
  EXPECT_EQ(decoded.header.lidar_id, 1);
  ASSERT_EQ(decoded.points.size(), 1U);
  expect_point(decoded.points[0], 10.0, -0.25, 1.5, kFloat);
  EXPECT_EQ(decoded.points[0].reflectivity, 37);
  EXPECT_EQ(decoded.points[0].shot, 0);
  std::vector<std::uint8_t> back;
  encode_points(decoded.header, decoded.points, back);
  EXPECT_EQ(back, bytes);
}

TEST(SamplePacket, ReadsTheSphericalExample) {
  const auto bytes = full_packet("05010100000000000001cb04fb711f01000082270000d31f118c25");
  const Decoded decoded = decode(bytes);
  ASSERT_EQ(decoded.points.size(), 1U);
  // The same point as the Cartesian example, after rounding to 0.01 degrees at 10 m.
  expect_point(decoded.points[0], 10.0, -0.25, 1.5, 0.0018);
  EXPECT_EQ(decoded.points[0].reflectivity, 37);
  std::vector<std::uint8_t> back;
  encode_points(decoded.header, decoded.points, back);
  EXPECT_EQ(back, bytes);
}

TEST(SamplePacket, ReadsTheRealTele15Packet) {
  const auto bytes = full_packet("050101004068004001028b06aee5b412f617f65c000008080000ab0500000f10");
  const Decoded decoded = decode(bytes);
  EXPECT_EQ(decoded.header.status, 0x40006840U);
  EXPECT_EQ(decoded.header.timestamp_type, TimestampType::ptp);
  EXPECT_EQ(decoded.header.device_stamp_ns, 1726588075299964555);
  ASSERT_EQ(decoded.points.size(), 1U);
  expect_point(decoded.points[0], 23.798, 2.056, 1.451, kFloat);
  EXPECT_EQ(decoded.points[0].reflectivity, 15);
  EXPECT_EQ(decoded.points[0].tag, 0x10);
}

TEST(SamplePacket, ReadsTheTaggedSphericalExample) {
  const auto bytes = full_packet("05010100000000000003801a0600000000007b5d0000cc21ee010f10");
  const Decoded decoded = decode(bytes);
  EXPECT_EQ(decoded.header.device_stamp_ns, 400000);
  ASSERT_EQ(decoded.points.size(), 1U);
  expect_point(decoded.points[0], 23.798, 2.056, 1.451, 0.005);  // Half of 0.01 degrees at 24 m, twice.
  EXPECT_EQ(decoded.points[0].tag, 0x10);
  std::vector<std::uint8_t> back;
  encode_points(decoded.header, decoded.points, back);
  EXPECT_EQ(back, bytes);
}

TEST(SamplePacket, ReadsTheDualExamples) {
  const auto cartesian =
      full_packet("05010100000000000004400d030000000000401f00006400000038ffffff1410d43000009c000000c8feffff5a20");
  const auto spherical = full_packet("05010100000000000005400d030000000000b7234800431f00001410d93000005a20");
  for (const auto& bytes : {cartesian, spherical}) {
    const Decoded decoded = decode(bytes);
    EXPECT_EQ(decoded.header.device_stamp_ns, 200000);
    ASSERT_EQ(decoded.points.size(), 2U);
    expect_point(decoded.points[0], 8.0, 0.1, -0.2, 0.002);
    expect_point(decoded.points[1], 12.5, 0.156, -0.312, 0.003);
    EXPECT_EQ(decoded.points[0].reflectivity, 20);
    EXPECT_EQ(decoded.points[1].reflectivity, 90);
    EXPECT_EQ(decode_tag(decoded.points[0].tag).return_number, 1);
    EXPECT_EQ(decode_tag(decoded.points[1].tag).return_number, 2);
    EXPECT_EQ(decoded.points[0].shot, 0);
    EXPECT_EQ(decoded.points[1].shot, 0);
    std::vector<std::uint8_t> back;
    encode_points(decoded.header, decoded.points, back);
    EXPECT_EQ(back, bytes);
  }
}

TEST(SamplePacket, ReadsTheTripleExamplesWithoutTheMissingEcho) {
  const auto cartesian = full_packet(
      "0501010000000000000748e8010000000000401f00006400000038ffffff1410d43000009c000000c8feffff5a20"
      "0000000000000000000000000030");
  const auto spherical =
      full_packet("0501010000000000000848e8010000000000b7234800431f00001410d93000005a20000000000030");
  for (const auto& bytes : {cartesian, spherical}) {
    const Decoded decoded = decode(bytes);
    EXPECT_EQ(decoded.header.device_stamp_ns, 125000);
    ASSERT_EQ(decoded.points.size(), 2U);
    expect_point(decoded.points[0], 8.0, 0.1, -0.2, 0.002);
    expect_point(decoded.points[1], 12.5, 0.156, -0.312, 0.003);
  }
}

TEST(SamplePacket, ReadsAndWritesTheImuExample) {
  const auto bytes = from_hex("05010100000000000006404b4c00000000000ad7233c0ad7a3bca69b443b00000000000000000000803f");
  const Expected<SamplePacket> packet = parse_sample_packet(bytes);
  ASSERT_TRUE(packet) << packet.error().message();
  EXPECT_EQ(packet->header.device_stamp_ns, 5000000);
  const Expected<ImuReading> reading = decode_imu(*packet);
  ASSERT_TRUE(reading);
  EXPECT_EQ(*reading, (ImuReading{{0.01F, -0.02F, 0.003F}, {0.0F, 0.0F, 1.0F}}));
  std::vector<std::uint8_t> back;
  encode_imu(packet->header, *reading, back);
  EXPECT_EQ(back, bytes);
}

TEST(SamplePacket, RefusesAnImuReadingThatIsNoNumber) {
  SampleHeader header;
  header.data_type = DataType::imu;
  std::vector<std::uint8_t> bytes;
  encode_imu(header, {{0.0F, std::numeric_limits<float>::quiet_NaN(), 0.0F}, {}}, bytes);
  EXPECT_FALSE(decode_imu(*parse_sample_packet(bytes)));
  encode_imu(header, {{}, {0.0F, 0.0F, std::numeric_limits<float>::infinity()}}, bytes);
  EXPECT_FALSE(decode_imu(*parse_sample_packet(bytes)));
}

TEST(SamplePacket, ReadsTheGpsAndPpsHeaders) {
  const auto gps = full_packet("0501010000820000030214090a117be9a435");
  const Decoded gps_packet = decode(gps);
  EXPECT_EQ(gps_packet.header.timestamp_type, TimestampType::gps);
  EXPECT_EQ(gps_packet.header.device_stamp_ns, 1599758100000123000);  // 2020-09-10 17:15:00.000123 UTC.
  EXPECT_EQ(decode_status(gps_packet.header.status).time_sync, TimeSync::gps);
  std::vector<std::uint8_t> back;
  encode_points(gps_packet.header, {}, back);
  EXPECT_EQ(back, gps);
  const auto pps = full_packet("0501010000c20000040215cd5b0700000000");
  const Decoded pps_packet = decode(pps);
  EXPECT_EQ(pps_packet.header.timestamp_type, TimestampType::pps_only);
  EXPECT_EQ(pps_packet.header.device_stamp_ns, 123456789);
  EXPECT_TRUE(pps_packet.points.empty());
}

TEST(SamplePacket, RefusesAGpsTimeThatIsNoDate) {
  const std::string start = "0501010000820000 0302";
  for (const std::string time :
       {"14001e11 00000000", "140d0a11 00000000", "14021e11 00000000", "14090a18 00000000", "14090a11 00a493d6"}) {
    EXPECT_FALSE(parse_sample_packet(full_packet(start + time))) << time;
  }
  EXPECT_TRUE(parse_sample_packet(full_packet(start + "14021d11 ffa393d6")));  // 29 February, last microsecond.
}

TEST(SamplePacket, RefusesHostileBytes) {
  const auto good = full_packet("05010100000000000000cb04fb711f010000");
  ASSERT_TRUE(parse_sample_packet(good));
  for (std::size_t size = 0; size < good.size(); ++size) {
    EXPECT_FALSE(parse_sample_packet(ByteView(good).first(size))) << size;
  }
  auto longer = good;
  longer.push_back(0);
  EXPECT_FALSE(parse_sample_packet(longer));
  const auto refused_with = [&good](std::size_t offset, std::uint8_t value) {
    auto bytes = good;
    bytes[offset] = value;
    return !parse_sample_packet(bytes);
  };
  EXPECT_TRUE(refused_with(0, 4));      // Version.
  EXPECT_TRUE(refused_with(8, 2));      // The reserved time stamp type.
  EXPECT_TRUE(refused_with(8, 5));      // An unknown one.
  EXPECT_TRUE(refused_with(9, 9));      // An unknown data type.
  EXPECT_TRUE(refused_with(9, 255));    // The same.
  EXPECT_TRUE(refused_with(9, 2));      // Another data type with another length.
  EXPECT_TRUE(refused_with(17, 0x80));  // A stamp of 292 years.
}

TEST(SamplePacket, LeavesOutImpossibleAngles) {
  const std::string header = "05010100000000000001cb04fb711f010000";
  EXPECT_EQ(decode(full_packet(header + "82270000 5046 a08c 25")).points.size(), 1U);  // 180 and 360 degrees.
  EXPECT_TRUE(decode(full_packet(header + "82270000 5146 a08c 25")).points.empty());
  EXPECT_TRUE(decode(full_packet(header + "82270000 5046 a18c 25")).points.empty());
  EXPECT_TRUE(decode(full_packet(header + "00000000 5046 a08c 25")).points.empty());  // Depth 0: no return.
}

TEST(SamplePacket, ATagAloneMakesNoReturn) {
  const std::string header = "05010100000000000002cb04fb711f010000";
  EXPECT_TRUE(decode(full_packet(header + "000000000000000000000000 ff 10")).points.empty());
  EXPECT_EQ(decode(full_packet(header + "000000000000000001000000 00 00")).points.size(), 1U);
}

/// Random bytes in every record: decoding and encoding them again must give the same bytes for Cartesian types as long
/// as the slots without a return hold zeros.
TEST(SamplePacket, RandomCartesianRecordsComeBackToTheByte) {
  Random random(11);
  for (const DataType type :
       {DataType::cartesian, DataType::cartesian_tagged, DataType::dual_cartesian, DataType::triple_cartesian}) {
    const RecordLayout& layout = record_layout(type);
    for (int round = 0; round < 50; ++round) {
      SampleHeader header;
      header.data_type = type;
      header.timestamp_type = kTimestampTypes[random.below(4)];
      header.status = static_cast<std::uint32_t>(random.next_u64());
      header.slot = static_cast<std::uint8_t>(1 + random.below(9));
      header.lidar_id = static_cast<std::uint8_t>(1 + random.below(3));
      // Any moment to 2255, in whole microseconds since GPS stamps have no more.
      header.device_stamp_ns = static_cast<std::int64_t>(946684800 + random.below(7000000000)) * 1000000000 +
                               static_cast<std::int64_t>(random.below(1000000)) * 1000;
      std::vector<Point> points;
      for (std::uint16_t shot = 0; shot < layout.slots; ++shot) {
        const auto echoes = random.below(layout.echoes + 1U);
        for (std::uint64_t echo = 0; echo < echoes; ++echo) {
          Point point;
          point.x = static_cast<float>(random.uniform(-450.0, 450.0));
          point.y = static_cast<float>(random.uniform(-450.0, 450.0));
          point.z = static_cast<float>(random.uniform(-450.0, 450.0));
          point.reflectivity = static_cast<std::uint8_t>(random.below(256));
          point.tag = layout.tagged ? static_cast<std::uint8_t>(random.below(256)) : std::uint8_t{0};
          point.shot = shot;
          points.push_back(point);
        }
      }
      std::vector<std::uint8_t> bytes;
      encode_points(header, points, bytes);
      const Decoded decoded = decode(bytes);
      EXPECT_EQ(decoded.header.device_stamp_ns, header.device_stamp_ns);
      EXPECT_EQ(decoded.header.status, header.status);
      EXPECT_EQ(decoded.header.slot, header.slot);
      EXPECT_EQ(decoded.header.lidar_id, header.lidar_id);
      ASSERT_EQ(decoded.points.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        // Half a millimetre of rounding and the float's own at 450 m.
        expect_point(decoded.points[i], points[i].x, points[i].y, points[i].z, 0.00055);
        EXPECT_EQ(decoded.points[i].reflectivity, points[i].reflectivity);
        EXPECT_EQ(decoded.points[i].tag, points[i].tag);
        EXPECT_EQ(decoded.points[i].shot, points[i].shot);
      }
      std::vector<std::uint8_t> again;
      encode_points(decoded.header, decoded.points, again);
      EXPECT_EQ(again, bytes);
    }
  }
}

TEST(SamplePacket, RandomSphericalPointsComeBackWithinTheirRounding) {
  Random random(12);
  for (const DataType type :
       {DataType::spherical, DataType::spherical_tagged, DataType::dual_spherical, DataType::triple_spherical}) {
    const RecordLayout& layout = record_layout(type);
    for (int round = 0; round < 50; ++round) {
      SampleHeader header;
      header.data_type = type;
      std::vector<Point> points;
      for (std::uint16_t shot = 0; shot < layout.slots; ++shot) {
        if (random.uniform() < 0.2) continue;
        Vector3d way(random.normal(), random.normal(), random.normal());
        way.normalize();
        double depth = random.uniform(0.5, 60.0);
        for (unsigned echo = 0; echo < layout.echoes; ++echo) {
          const Vector3d at = way * depth;
          points.push_back({static_cast<float>(at.x()), static_cast<float>(at.y()), static_cast<float>(at.z()),
                            static_cast<std::uint8_t>(random.below(256)),
                            layout.tagged ? static_cast<std::uint8_t>(random.below(256)) : std::uint8_t{0}, shot});
          depth += random.uniform(0.5, 20.0);
        }
      }
      std::vector<std::uint8_t> bytes;
      encode_points(header, points, bytes);
      const Decoded decoded = decode(bytes);
      ASSERT_EQ(decoded.points.size(), points.size());
      for (std::size_t i = 0; i < points.size(); ++i) {
        // Half of 0.01 degrees in both angles at up to 100 m: 12 mm; half a millimetre of depth.
        expect_point(decoded.points[i], points[i].x, points[i].y, points[i].z, 0.013);
        EXPECT_EQ(decoded.points[i].reflectivity, points[i].reflectivity);
        EXPECT_EQ(decoded.points[i].tag, points[i].tag);
        EXPECT_EQ(decoded.points[i].shot, points[i].shot);
      }
    }
  }
}

TEST(SamplePacket, RandomRecordsNeverLeaveTheBuffer) {
  Random random(13);
  std::vector<Point> points;
  for (const DataType type : kPointTypes) {
    for (int round = 0; round < 100; ++round) {
      std::vector<std::uint8_t> bytes = full_packet("05010100000000000000cb04fb711f010000");
      bytes[9] = static_cast<std::uint8_t>(type);
      bytes.resize(packet_bytes(type));
      for (std::size_t i = kSampleHeaderBytes; i < bytes.size(); ++i) {
        bytes[i] = static_cast<std::uint8_t>(random.below(256));
      }
      const Expected<SamplePacket> packet = parse_sample_packet(bytes);
      ASSERT_TRUE(packet);
      decode_points(*packet, points);
      const RecordLayout& layout = record_layout(type);
      EXPECT_LE(points.size(), std::size_t{layout.slots} * layout.echoes);
      for (const Point& point : points) {
        EXPECT_LT(point.shot, layout.slots);
        EXPECT_TRUE(std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z));
      }
    }
  }
}

TEST(SamplePacket, AzimuthJustBelowAFullTurnIsWrittenAsAnAngleOfThePage) {
  SampleHeader header;
  header.data_type = DataType::spherical;
  const Point point{10.0F, -1e-6F, 0.0F, 0, 0, 0};
  std::vector<std::uint8_t> bytes;
  encode_points(header, std::array{point}, bytes);
  const Decoded decoded = decode(bytes);
  ASSERT_EQ(decoded.points.size(), 1U);
  expect_point(decoded.points[0], 10.0, 0.0, 0.0, 1e-5);
}

TEST(OverwriteStamp, ChangesStatusAndStampAlone) {
  for (const TimestampType type :
       {TimestampType::since_start, TimestampType::ptp, TimestampType::gps, TimestampType::pps_only}) {
    SampleHeader header;
    header.slot = 3;
    header.lidar_id = 2;
    header.data_type = DataType::spherical;
    std::vector<std::uint8_t> packet;
    const std::vector<Point> points{{1.0F, 2.0F, 3.0F, 40, 0, 7}};
    encode_points(header, points, packet);
    const std::vector<std::uint8_t> before = packet;
    overwrite_stamp(0x40006840, type, 1'600'000'000'123'456'000, packet);
    const auto after = parse_sample_packet(packet);
    ASSERT_TRUE(after.has_value());
    EXPECT_EQ(after->header.slot, 3);
    EXPECT_EQ(after->header.lidar_id, 2);
    EXPECT_EQ(after->header.status, 0x40006840U);
    EXPECT_EQ(after->header.timestamp_type, type);
    EXPECT_EQ(after->header.data_type, DataType::spherical);
    EXPECT_EQ(after->header.device_stamp_ns, 1'600'000'000'123'456'000);
    EXPECT_TRUE(std::equal(packet.begin() + 18, packet.end(), before.begin() + 18, before.end()));
  }
}

}  // namespace
}  // namespace rigcal::livox
