#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/bytes.h"
#include "core/base/error.h"
#include "core/io/intensity_range.h"
#include "core/records/records.h"

/// ROS 1 messages out of their bytes. Any bytes may be given: sizes are checked before they are believed, no memory is
/// taken beyond what the bytes fill. An Error says what is wrong, without a place.
namespace rigcal {

enum class RosType {
  livox_points,      ///< livox_ros_driver/CustomMsg, livox_ros_driver2/CustomMsg
  point_cloud,       ///< sensor_msgs/PointCloud2
  imu,               ///< sensor_msgs/Imu
  image,             ///< sensor_msgs/Image
  compressed_image,  ///< sensor_msgs/CompressedImage
  other,
};

[[nodiscard]] RosType ros_type(std::string_view name);
/// Whether this checksum is that of the layout which is read here; "*" stands for any.
[[nodiscard]] bool is_known_layout(RosType type, std::string_view md5);

/// The std_msgs/Header that every message begins with.
struct RosHeader {
  std::uint32_t seq = 0;
  std::int64_t stamp_ns = 0;  ///< The sender's clock; 0 where it filled in none.
};

/// A cloud's points; an object may be used again for the next one.
struct RosCloud {
  RosHeader header;
  int lidar_id = 0;           ///< Of the LiDAR among those of a Livox driver; 0 for a PointCloud2.
  std::vector<Point> points;  ///< Point::shot means nothing.
  /// The sender's time of each point; empty where the points have none. As they came, not in order.
  std::vector<std::int64_t> times_ns;
  std::uint64_t shots = 0;       ///< All places for points in the message.
  std::uint64_t not_finite = 0;  ///< Left out: a coordinate is NaN or infinite.
  std::uint64_t at_origin = 0;   ///< Left out: (0, 0, 0), written where nothing came back.
  IntensityRange intensity;      ///< As the message has it.
};

/// `type` is livox_points or point_cloud. PointCloud2: x, y, z as float32 or float64 wherever they stand; intensity or
/// reflectivity of any type, rounded and kept within 0 .. 255; tag. Times from the first of offset_time, t, time,
/// timestamp: whole numbers are ns after the header's stamp, float32 seconds after it, float64 seconds or, where they
/// are too large or too far apart for that, ns, each after it or, beyond 10 s, of the sender's clock; none where one is
/// no number. Errors: cut, sizes that contradict each other, no x, y, z.
[[nodiscard]] Expected<void> decode_cloud(RosType type, ByteView message, RosCloud& cloud);

struct RosImu {
  RosHeader header;
  Vector3d gyro_rad_s = Vector3d::Zero();
  Vector3d acceleration = Vector3d::Zero();  ///< m/s^2 by the standard; Livox's drivers send g.
  bool has_gyro = true;                      ///< False: the sender says that it measures no rates.
};
[[nodiscard]] Expected<RosImu> decode_imu(ByteView message);

/// An image; the views lie in the message.
struct RosImage {
  RosHeader header;
  std::uint32_t width = 0;   ///< 0 for a compressed image.
  std::uint32_t height = 0;  ///< The same.
  std::uint32_t step = 0;    ///< Bytes from row to row.
  bool big_endian = false;
  std::string encoding;  ///< "mono8", "bayer_rggb8" and so on; of a compressed image its "format".
  ByteView data;
};
/// `type` is image or compressed_image. Errors: cut, fewer bytes than the size needs.
[[nodiscard]] Expected<RosImage> decode_image(RosType type, ByteView message);

}  // namespace rigcal
