#include <algorithm>
#include <cstdint>
#include <cstring>
#include <vector>

#include "core/base/error.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/sample_packet.h"

// Any datagram: it must be refused or come back unchanged from a round trip, never read past its end. The checksums of
// control frames, which a fuzzer cannot guess, are also put right.
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

void check_control_frame(rigcal::ByteView bytes) {
  const auto frame = parse_control_frame(bytes);
  if (!frame) return;
  const auto back = make_control_frame(*frame);
  RIGCAL_ASSERT(std::equal(back.begin(), back.end(), bytes.begin()), "a frame has changed");
  if (const auto broadcast = parse_broadcast(*frame)) {
    RIGCAL_ASSERT(make_broadcast(*broadcast, frame->seq) == back, "a broadcast has changed");
  }
  if (const auto handshake = parse_handshake(*frame)) {
    RIGCAL_ASSERT(make_handshake(*handshake, frame->seq, frame->type) == back, "a handshake has changed");
  }
}

template <class Checksum>
void put_checksum(std::vector<std::uint8_t>& bytes, std::size_t at, Checksum checksum) {
  std::memcpy(bytes.data() + at, &checksum, sizeof checksum);
}

std::vector<std::uint8_t> with_checksums(rigcal::ByteView bytes) {
  std::vector<std::uint8_t> frame(bytes.begin(), bytes.end());
  if (frame.size() < kMinFrameBytes || frame.size() > kMaxFrameBytes) return frame;
  frame[0] = 0xAA;
  frame[1] = 1;
  put_checksum(frame, 2, static_cast<std::uint16_t>(frame.size()));
  put_checksum(frame, 7, crc16(rigcal::ByteView(frame).first(7)));
  put_checksum(frame, frame.size() - 4, crc32(rigcal::ByteView(frame).first(frame.size() - 4)));
  return frame;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* bytes, std::size_t size) {
  const rigcal::ByteView view(bytes, size);
  check_sample_packet(view);
  check_control_frame(view);
  check_control_frame(with_checksums(view));
  return 0;
}
