#include <cstdint>
#include <vector>

#include "core/base/error.h"
#include "drivers/livox_codec/sample_packet.h"

// Sample packets of any bytes: refused, or unchanged after a round trip, never read past the end.
namespace {

using namespace rigcal::livox;

void check_sample_packet(rigcal::ByteView bytes) {
  const auto packet = parse_sample_packet(bytes);
  if (!packet) return;
  RIGCAL_ASSERT(bytes.size() == packet_bytes(packet->header.data_type), "a packet of another length");
  std::vector<std::uint8_t> back;
  if (packet->header.data_type == DataType::imu) {
    if (const auto reading = decode_imu(*packet)) {
      encode_imu(packet->header, *reading, back);
      const auto again = parse_sample_packet(back);
      RIGCAL_ASSERT(again && *decode_imu(*again) == *reading, "an IMU reading has changed");
    }
    return;
  }
  std::vector<rigcal::Point> points;
  decode_points(*packet, points);
  for (const rigcal::Point& point : points) {
    // Floats carry millimetres up to 16 km; what lies farther need not survive.
    if (!(point.x * point.x + point.y * point.y + point.z * point.z < 1.0e8F)) return;
  }
  encode_points(packet->header, points, back);
  std::vector<rigcal::Point> points_again;
  const auto again = parse_sample_packet(back);
  RIGCAL_ASSERT(again && again->header.device_stamp_ns == packet->header.device_stamp_ns, "a stamp has changed");
  decode_points(*again, points_again);
  RIGCAL_ASSERT(points_again.size() == points.size(), "points have come or gone");
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ByteView view(bytes, size);
  check_sample_packet(view);
  return 0;
}
