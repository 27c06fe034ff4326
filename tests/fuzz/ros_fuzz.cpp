// A ROS message of any bytes, the first one choosing the type: no crash, every point counted, nothing read past the
// end.
#include <cmath>

#include "core/io/ros_messages.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) return 0;
  const rigcal::ByteView message(bytes + 1, size - 1);
  switch (bytes[0] % 5) {
    case 0:
    case 1: {
      rigcal::RosCloud cloud;
      const auto type = bytes[0] % 5 == 0 ? rigcal::RosType::livox_points : rigcal::RosType::point_cloud;
      if (!rigcal::decode_cloud(type, message, cloud)) return 0;
      if (cloud.points.size() + cloud.not_finite + cloud.at_origin != cloud.shots) __builtin_trap();
      if (!cloud.times_ns.empty() && cloud.times_ns.size() != cloud.points.size()) __builtin_trap();
      for (const rigcal::Point& p : cloud.points) {
        if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) __builtin_trap();
      }
      break;
    }
    case 2:
      static_cast<void>(rigcal::decode_imu(message).has_value());
      break;
    default: {
      const auto type = bytes[0] % 5 == 3 ? rigcal::RosType::image : rigcal::RosType::compressed_image;
      const auto image = rigcal::decode_image(type, message);
      if (image && std::uint64_t{image->step} * image->height > image->data.size()) __builtin_trap();
    }
  }
  return 0;
}
