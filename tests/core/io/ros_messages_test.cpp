#include "core/io/ros_messages.h"

#include <gmock/gmock.h>

#include <cmath>
#include <limits>

#include "tests/support/ros_bytes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

constexpr std::int64_t message_stamp = 1'700'000'000'123'456'789;
const Vector3d zero = Vector3d::Zero();

std::string fault(RosType type, const RosBytes& bytes) {
  RosCloud cloud;
  const Expected<void> decoded = decode_cloud(type, bytes, cloud);
  return decoded ? "" : decoded.error().message();
}

/// Appends values of any kinds, in either byte order.
template <class T>
void put(RosBytes& data, T value, bool big_endian) {
  RosBytes bytes;
  ByteWriter(bytes).write(value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  data.insert(data.end(), bytes.begin(), bytes.end());
}

TEST(RosMessages, ReadsLivoxPointsToTheLastBit) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const RosBytes bytes = livox_message(4, message_stamp,
                                       {{{1.1F, -2.2F, 3.3F, 200, 0x10, 0}, 0},
                                        {{nan, 0, 0, 1, 1, 0}, 5},
                                        {{}, 6},
                                        {{4.0F, 5.0F, 6.0F, 3, 2, 0}, 99'999'999}});
  RosCloud cloud;
  ASSERT_TRUE(decode_cloud(RosType::livox_points, bytes, cloud).has_value());
  EXPECT_EQ(cloud.header.seq, 4U);
  EXPECT_EQ(cloud.header.stamp_ns, message_stamp);
  EXPECT_EQ(cloud.shots, 4U);
  EXPECT_EQ(cloud.not_finite, 1U);
  EXPECT_EQ(cloud.at_origin, 1U);
  ASSERT_EQ(cloud.points.size(), 2U);
  EXPECT_EQ(cloud.points[0].x, 1.1F);
  EXPECT_EQ(cloud.points[0].z, 3.3F);
  EXPECT_EQ(cloud.points[0].reflectivity, 200);
  EXPECT_EQ(cloud.points[0].tag, 0x10);
  EXPECT_EQ(cloud.times_ns, (std::vector<std::int64_t>{message_stamp, message_stamp + 99'999'999}));
}

TEST(RosMessages, ReadsPointCloudsWhereverTheirFieldsStand) {
  for (const bool big : {false, true}) {
    // y as a double, x and z as floats, intensity as uint16, tag; a row of padding bytes; a time in seconds.
    const std::vector<CloudField> fields{{"y", 2, 8},  {"tag", 0, 2},        {"z", 10, 7},
                                         {"x", 14, 7}, {"intensity", 18, 4}, {"time", 20, 7}};
    RosBytes data;
    for (int row = 0; row < 2; ++row) {
      for (int i = 0; i < 2; ++i) {
        put(data, static_cast<std::uint8_t>(8 + i), big);
        put(data, std::uint8_t{0}, big);
        put(data, 2.5 + row, big);
        put(data, -1.25F, big);
        put(data, row == 1 && i == 1 ? std::numeric_limits<float>::infinity() : 10.0F + static_cast<float>(i), big);
        put(data, static_cast<std::uint16_t>(i == 0 ? 77 : 4000), big);
        put(data, 0.01F * static_cast<float>(i), big);
      }
      data.resize(data.size() + 5);
    }
    const RosBytes bytes = cloud_message(1, message_stamp, fields, {2, 2, 24, 53, big}, data);
    RosCloud cloud;
    const Expected<void> decoded = decode_cloud(RosType::point_cloud, bytes, cloud);
    ASSERT_TRUE(decoded.has_value()) << decoded.error().message();
    EXPECT_EQ(cloud.not_finite, 1U);
    ASSERT_EQ(cloud.points.size(), 3U);
    EXPECT_EQ(cloud.points[1].x, 11.0F);
    EXPECT_EQ(cloud.points[1].y, 2.5F);
    EXPECT_EQ(cloud.points[1].z, -1.25F);
    EXPECT_EQ(cloud.points[0].reflectivity, 77);
    EXPECT_EQ(cloud.points[1].reflectivity, 255) << "kept within a byte";
    EXPECT_EQ(cloud.intensity.largest, 4000.0) << "and told of";
    EXPECT_EQ(cloud.points[1].tag, 9);
    EXPECT_EQ(cloud.points[2].y, 3.5F);
    EXPECT_NEAR(static_cast<double>(cloud.times_ns[1] - message_stamp), 1e7, 1.0);
  }
}

TEST(RosMessages, UnderstandsTheTimesOfDifferentDrivers) {
  const auto time_of = [](const char* name, std::uint8_t datatype, auto value) {
    RosBytes data;
    for (const float c : {1.0F, 2.0F, 3.0F}) put(data, c, false);
    put(data, value, false);
    const auto step = static_cast<std::uint32_t>(data.size());
    const RosBytes bytes =
        cloud_message(1, message_stamp, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {name, 12, datatype}},
                      {1, 1, step, step, false}, data);
    RosCloud cloud;
    EXPECT_TRUE(decode_cloud(RosType::point_cloud, bytes, cloud).has_value());
    return cloud.times_ns.empty() ? std::int64_t{-1} : cloud.times_ns[0] - message_stamp;
  };
  EXPECT_EQ(time_of("t", 6, std::uint32_t{50'000'000}), 50'000'000);
  EXPECT_EQ(time_of("offset_time", 6, std::uint32_t{12}), 12);
  EXPECT_EQ(time_of("time", 7, -0.5F), -500'000'000);
  EXPECT_EQ(time_of("timestamp", 8, 0.25), 250'000'000);
  EXPECT_NEAR(static_cast<double>(time_of("timestamp", 8, 1e-9 * static_cast<double>(message_stamp) + 0.05)), 5e7,
              500.0);
  EXPECT_NEAR(static_cast<double>(time_of("timestamp", 8, static_cast<double>(message_stamp) + 7e7)), 7e7, 500.0);
  EXPECT_EQ(time_of("timestamp", 8, 500.5) + message_stamp, 500'500'000'000) << "since the sender was switched on";
  EXPECT_EQ(time_of("timestamp", 8, 500.5e9) + message_stamp, 500'500'000'000);
  EXPECT_EQ(time_of("timestamp", 8, std::numeric_limits<double>::quiet_NaN()), -1);
  EXPECT_EQ(time_of("timestamp", 8, 1e300), -1);
  EXPECT_EQ(time_of("ring", 4, std::uint16_t{3}), -1) << "no time at all";
  time_of("time", 7, std::numeric_limits<float>::max());  // whatever it gives, no overflow
}

// Within the first seconds of a clock that counts ns their size tells nothing: their span does.
TEST(RosMessages, TellsSecondsFromNanosecondsByTheSpanOfACloud) {
  const auto span_ns = [](double first, double last) {
    RosBytes data;
    for (const double time : {first, last}) {
      for (const float c : {1.0F, 2.0F, 3.0F}) put(data, c, false);
      put(data, time, false);
    }
    const RosBytes bytes = cloud_message(
        1, message_stamp, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}, {"timestamp", 12, 8}}, {1, 2, 20, 40, false}, data);
    RosCloud cloud;
    EXPECT_TRUE(decode_cloud(RosType::point_cloud, bytes, cloud).has_value());
    return cloud.times_ns.at(1) - cloud.times_ns.at(0);
  };
  EXPECT_EQ(span_ns(5.0e9, 5.1e9), 100'000'000);
  EXPECT_EQ(span_ns(0.0, 1e8), 100'000'000);
  EXPECT_EQ(span_ns(0.0, 0.125), 125'000'000);
  EXPECT_EQ(span_ns(-1.0, 0.5), 1'500'000'000);
}

TEST(RosMessages, RefusesCloudsThatContradictThemselves) {
  const std::vector<CloudField> xyz{{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
  const RosBytes data(24);
  const auto wrong = [&](const std::vector<CloudField>& fields, const CloudShape& shape) {
    return fault(RosType::point_cloud, cloud_message(1, message_stamp, fields, shape, data));
  };
  EXPECT_EQ(wrong(xyz, {1, 2, 12, 24, false}), "");
  EXPECT_EQ(wrong(xyz, {1, 2, 12, 0, false}), "") << "one row needs no step";
  EXPECT_EQ(wrong(xyz, {0, 0, 12, 0, false}), "");
  EXPECT_THAT(wrong(xyz, {1, 3, 12, 36, false}), HasSubstr("fewer bytes"));
  EXPECT_THAT(wrong(xyz, {2, 1, 12, 4, false}), HasSubstr("fewer bytes"));
  EXPECT_THAT(wrong(xyz, {0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, 0xFFFFFFFF, false}), HasSubstr("fewer bytes"));
  EXPECT_THAT(wrong(xyz, {1, 0xFFFFFFFF, 0, 0, false}), HasSubstr("reaches out"));
  EXPECT_THAT(wrong({{"x", 0, 7}, {"y", 4, 7}, {"z", 0xFFFFFFFF, 7}}, {1, 2, 12, 24, false}), HasSubstr("reaches out"));
  EXPECT_THAT(wrong({{"x", 0, 7}, {"y", 4, 7}}, {1, 2, 12, 24, false}), HasSubstr("no fields x, y and z"));
  EXPECT_THAT(wrong({{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 200}}, {1, 2, 12, 24, false}), HasSubstr("x, y and z"));
  EXPECT_THAT(wrong({{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 5}}, {1, 2, 12, 24, false}), HasSubstr("x, y and z"));
}

// Found by the fuzzer: four billion rows of no points took half a minute.
TEST(RosMessages, RowsWithoutPointsAreNoWork) {
  const std::vector<CloudField> fields{{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}};
  RosCloud cloud;
  ASSERT_TRUE(decode_cloud(RosType::point_cloud,
                           cloud_message(1, message_stamp, fields, {4'294'967'295U, 0, 12, 0, false}, {}), cloud));
  EXPECT_EQ(cloud.shots, 0U);
  EXPECT_TRUE(cloud.points.empty());
}

TEST(RosMessages, ReadsReadingsAndImages) {
  const Expected<RosImu> imu =
      decode_imu(imu_message(1, message_stamp, Vector3d(0.1, 0.2, 0.3), Vector3d(0.0, 0.0, 9.8)));
  ASSERT_TRUE(imu.has_value());
  EXPECT_EQ(imu->gyro_rad_s, Vector3d(0.1, 0.2, 0.3));
  EXPECT_EQ(imu->acceleration, Vector3d(0.0, 0.0, 9.8));
  EXPECT_TRUE(imu->has_gyro);
  EXPECT_FALSE(decode_imu(imu_message(1, message_stamp, zero, zero, -1.0))->has_gyro);
  EXPECT_FALSE(decode_imu(imu_message(1, message_stamp, Vector3d(std::nan(""), 0.0, 0.0), zero)).has_value());

  const RosBytes pixels{1, 2, 3, 4, 5, 6, 7, 8};
  const RosBytes bytes = image_message(2, message_stamp, 3, 2, "mono8", 4, pixels);
  const Expected<RosImage> image = decode_image(RosType::image, bytes);
  ASSERT_TRUE(image.has_value());
  EXPECT_EQ(image->width, 3U);
  EXPECT_EQ(image->height, 2U);
  EXPECT_EQ(image->encoding, "mono8");
  EXPECT_EQ(image->data.size(), 8U);
  EXPECT_FALSE(decode_image(RosType::image, image_message(2, message_stamp, 3, 3, "mono8", 4, pixels)).has_value());
  const RosBytes packed = compressed_message(2, message_stamp, "bayer_rggb8; jpeg compressed", pixels);
  const Expected<RosImage> compressed = decode_image(RosType::compressed_image, packed);
  ASSERT_TRUE(compressed.has_value());
  EXPECT_EQ(compressed->encoding, "bayer_rggb8; jpeg compressed");
  EXPECT_EQ(compressed->data.size(), 8U);
}

TEST(RosMessages, RefusesWhatIsCutAnywhere) {
  const RosBytes livox = livox_message(1, message_stamp, {{}, {}});
  const RosBytes cloud =
      cloud_message(1, message_stamp, {{"x", 0, 7}, {"y", 4, 7}, {"z", 8, 7}}, {1, 2, 12, 24, false}, RosBytes(24));
  const RosBytes imu = imu_message(1, message_stamp, zero, zero);
  const RosBytes image = image_message(2, message_stamp, 3, 2, "mono8", 4, RosBytes(8));
  const auto cut = [](const RosBytes& bytes, std::size_t size) {
    return RosBytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
  };
  for (std::size_t n = 0; n < livox.size(); ++n) EXPECT_NE(fault(RosType::livox_points, cut(livox, n)), "") << n;
  // The last byte of a cloud, is_dense, is not needed.
  for (std::size_t n = 0; n + 1 < cloud.size(); ++n) EXPECT_NE(fault(RosType::point_cloud, cut(cloud, n)), "") << n;
  for (std::size_t n = 0; n < imu.size(); ++n) EXPECT_FALSE(decode_imu(cut(imu, n)).has_value()) << n;
  for (std::size_t n = 0; n < image.size(); ++n) {
    EXPECT_FALSE(decode_image(RosType::image, cut(image, n)).has_value()) << n;
  }
}

TEST(RosMessages, KnowsTheLayoutsOfTheTypes) {
  EXPECT_EQ(ros_type("livox_ros_driver2/CustomMsg"), RosType::livox_points);
  EXPECT_EQ(ros_type("std_msgs/String"), RosType::other);
  EXPECT_TRUE(is_known_layout(ros_type(cloud_type), cloud_md5));
  EXPECT_TRUE(is_known_layout(ros_type(cloud_type), "*"));
  EXPECT_FALSE(is_known_layout(ros_type(cloud_type), imu_md5));
}

}  // namespace
}  // namespace rigcal
