#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/bytes.h"
#include "core/records/records.h"

/// ROS 1 messages written down from their definitions.
namespace rigcal {

inline const char* const livox_type = "livox_ros_driver/CustomMsg";
inline const char* const livox_md5 = "e4d6829bdfe657cb6c21a746c86b21a6";
inline const char* const cloud_type = "sensor_msgs/PointCloud2";
inline const char* const cloud_md5 = "1158d486dd51d683ce2f1be655c3c181";
inline const char* const imu_type = "sensor_msgs/Imu";
inline const char* const imu_md5 = "6a62c6daae103f4ff57a132d6f95cec2";
inline const char* const image_type = "sensor_msgs/Image";
inline const char* const image_md5 = "060021388200f6f0f447d0fcd9c64743";
inline const char* const compressed_type = "sensor_msgs/CompressedImage";
inline const char* const compressed_md5 = "8f7a12909da2c9d3332d540a0977563f";

using RosBytes = std::vector<std::uint8_t>;

inline void put_text(ByteWriter& out, const std::string& text) {
  out.write(static_cast<std::uint32_t>(text.size()));
  out.write_text(text, text.size());
}

inline void put_header(ByteWriter& out, std::uint32_t seq, std::int64_t stamp_ns) {
  out.write(seq);
  out.write(static_cast<std::uint32_t>(stamp_ns / 1'000'000'000));
  out.write(static_cast<std::uint32_t>(stamp_ns % 1'000'000'000));
  put_text(out, "livox_frame");
}

/// A point and its time after the first of its message.
struct RosPoint {
  Point point;
  std::uint32_t offset_ns = 0;
};

inline RosBytes livox_message(std::uint32_t seq, std::int64_t stamp_ns, const std::vector<RosPoint>& points,
                              std::uint8_t lidar_id = 0) {
  RosBytes bytes;
  ByteWriter out(bytes);
  put_header(out, seq, stamp_ns);
  out.write(static_cast<std::uint64_t>(stamp_ns));
  out.write(static_cast<std::uint32_t>(points.size()));
  out.write(lidar_id);
  for (int i = 0; i < 3; ++i) out.write(std::uint8_t{0});
  out.write(static_cast<std::uint32_t>(points.size()));
  for (const auto& [point, offset_ns] : points) {
    out.write(offset_ns);
    out.write(point.x);
    out.write(point.y);
    out.write(point.z);
    out.write(point.reflectivity);
    out.write(point.tag);
    out.write(std::uint8_t{3});  // line
  }
  return bytes;
}

inline RosBytes imu_message(std::uint32_t seq, std::int64_t stamp_ns, const Vector3d& gyro,
                            const Vector3d& acceleration, double first_covariance = 0.0) {
  RosBytes bytes;
  ByteWriter out(bytes);
  put_header(out, seq, stamp_ns);
  for (int i = 0; i < 13; ++i) out.write(0.0);
  for (int i = 0; i < 3; ++i) out.write(gyro[i]);
  out.write(first_covariance);
  for (int i = 0; i < 8; ++i) out.write(0.0);
  for (int i = 0; i < 3; ++i) out.write(acceleration[i]);
  for (int i = 0; i < 9; ++i) out.write(0.0);
  return bytes;
}

struct CloudField {
  std::string name;
  std::uint32_t offset = 0;
  std::uint8_t datatype = 7;  ///< 1 int8, 2 uint8, 3 int16, 4 uint16, 5 int32, 6 uint32, 7 float32, 8 float64
};

struct CloudShape {
  std::uint32_t height = 1;
  std::uint32_t width = 0;
  std::uint32_t point_step = 0;
  std::uint32_t row_step = 0;
  bool big_endian = false;
};

inline RosBytes cloud_message(std::uint32_t seq, std::int64_t stamp_ns, const std::vector<CloudField>& fields,
                              const CloudShape& shape, const RosBytes& data) {
  RosBytes bytes;
  ByteWriter out(bytes);
  put_header(out, seq, stamp_ns);
  out.write(shape.height);
  out.write(shape.width);
  out.write(static_cast<std::uint32_t>(fields.size()));
  for (const CloudField& field : fields) {
    put_text(out, field.name);
    out.write(field.offset);
    out.write(field.datatype);
    out.write(std::uint32_t{1});
  }
  out.write(static_cast<std::uint8_t>(shape.big_endian ? 1 : 0));
  out.write(shape.point_step);
  out.write(shape.row_step);
  out.write(static_cast<std::uint32_t>(data.size()));
  out.write_bytes(data);
  out.write(std::uint8_t{1});
  return bytes;
}

inline RosBytes image_message(std::uint32_t seq, std::int64_t stamp_ns, std::uint32_t width, std::uint32_t height,
                              const std::string& encoding, std::uint32_t step, const RosBytes& data,
                              bool big_endian = false) {
  RosBytes bytes;
  ByteWriter out(bytes);
  put_header(out, seq, stamp_ns);
  out.write(height);
  out.write(width);
  put_text(out, encoding);
  out.write(static_cast<std::uint8_t>(big_endian ? 1 : 0));
  out.write(step);
  out.write(static_cast<std::uint32_t>(data.size()));
  out.write_bytes(data);
  return bytes;
}

inline RosBytes compressed_message(std::uint32_t seq, std::int64_t stamp_ns, const std::string& format,
                                   const RosBytes& data) {
  RosBytes bytes;
  ByteWriter out(bytes);
  put_header(out, seq, stamp_ns);
  put_text(out, format);
  out.write(static_cast<std::uint32_t>(data.size()));
  out.write_bytes(data);
  return bytes;
}

}  // namespace rigcal
