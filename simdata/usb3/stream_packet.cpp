#include "simdata/usb3/stream_packet.h"

#include "core/base/bytes.h"

namespace rigcal::sim::usb3 {
namespace {

constexpr std::uint32_t leader_key = 0x4C563355;   // "U3VL"
constexpr std::uint32_t trailer_key = 0x54563355;  // "U3VT"
constexpr std::uint16_t image_payload = 0x0001;

}  // namespace

std::vector<std::uint8_t> encode_leader(const FrameOrder& frame, std::uint64_t stamp_ns) {
  std::vector<std::uint8_t> bytes;
  ByteWriter writer(bytes);
  const CameraSettings& settings = frame.settings;
  writer.write(leader_key);
  writer.write(std::uint16_t{0});
  writer.write(static_cast<std::uint16_t>(kLeaderBytes));
  writer.write(frame.number);
  writer.write(std::uint16_t{0});
  writer.write(image_payload);
  writer.write(stamp_ns);
  writer.write(settings.pixel_format);
  for (const int size : {settings.width, settings.height, settings.offset_x, settings.offset_y})
    writer.write(static_cast<std::uint32_t>(size));
  writer.write(std::uint32_t{0});  // No padding of rows.
  return bytes;
}

std::vector<std::uint8_t> encode_trailer(const FrameOrder& frame) {
  std::vector<std::uint8_t> bytes;
  ByteWriter writer(bytes);
  writer.write(trailer_key);
  writer.write(std::uint16_t{0});
  writer.write(static_cast<std::uint16_t>(kTrailerBytes));
  writer.write(frame.number);
  writer.write(std::uint32_t{0});  // Success.
  writer.write(static_cast<std::uint64_t>(frame.settings.image_bytes));
  writer.write(static_cast<std::uint32_t>(frame.settings.height));
  return bytes;
}

}  // namespace rigcal::sim::usb3
