#include "core/io/ros_messages.h"

#include "core/io/bag_record.h"
#include "core/io/ros_reader.h"

namespace rigcal {

RosType ros_type(std::string_view name) {
  if (name == "livox_ros_driver/CustomMsg" || name == "livox_ros_driver2/CustomMsg") return RosType::livox_points;
  if (name == "sensor_msgs/PointCloud2") return RosType::point_cloud;
  if (name == "sensor_msgs/Imu") return RosType::imu;
  if (name == "sensor_msgs/Image") return RosType::image;
  if (name == "sensor_msgs/CompressedImage") return RosType::compressed_image;
  return RosType::other;
}

bool is_known_layout(RosType type, std::string_view md5) {
  if (md5 == "*") return true;
  switch (type) {
    case RosType::livox_points:
      return md5 == "e4d6829bdfe657cb6c21a746c86b21a6";
    case RosType::point_cloud:
      return md5 == "1158d486dd51d683ce2f1be655c3c181";
    case RosType::imu:
      return md5 == "6a62c6daae103f4ff57a132d6f95cec2";
    case RosType::image:
      return md5 == "060021388200f6f0f447d0fcd9c64743";
    case RosType::compressed_image:
      return md5 == "8f7a12909da2c9d3332d540a0977563f";
    case RosType::other:
      return false;
  }
  return false;
}

Expected<RosImu> decode_imu(ByteView message) {
  ByteReader reader(message);
  RosImu imu;
  imu.header = read_ros_header(reader);
  constexpr std::size_t orientation_bytes = (4 + 9) * sizeof(double);
  static_cast<void>(reader.take(orientation_bytes));
  for (int i = 0; i < 3; ++i) imu.gyro_rad_s[i] = reader.read<double>();
  const auto first_covariance = reader.read<double>();
  imu.has_gyro = first_covariance != -1.0;  // so the message's definition
  static_cast<void>(reader.take(8 * sizeof(double)));
  for (int i = 0; i < 3; ++i) imu.acceleration[i] = reader.read<double>();
  static_cast<void>(reader.take(9 * sizeof(double)));
  if (!reader.ok()) return message_is_cut();
  if (!imu.gyro_rad_s.allFinite() || !imu.acceleration.allFinite()) return input_error("a reading is no number");
  return imu;
}

Expected<RosImage> decode_image(RosType type, ByteView message) {
  ByteReader reader(message);
  RosImage image;
  image.header = read_ros_header(reader);
  if (type == RosType::image) {
    image.height = reader.read<std::uint32_t>();
    image.width = reader.read<std::uint32_t>();
  }
  image.encoding = printable(read_ros_text(reader));
  if (type == RosType::image) {
    image.big_endian = reader.read<std::uint8_t>() != 0;
    image.step = reader.read<std::uint32_t>();
  }
  image.data = reader.take(reader.read<std::uint32_t>());
  if (!reader.ok()) return message_is_cut();
  if (std::uint64_t{image.step} * image.height > image.data.size()) {
    return input_error("has fewer bytes than its size needs");
  }
  return image;
}

}  // namespace rigcal
