#include "drivers/livox_codec/control_frame.h"

#include <array>
#include <string>

namespace rigcal::livox {
namespace {

constexpr std::uint8_t start_byte = 0xAA;
constexpr std::uint8_t protocol_version = 1;
constexpr std::size_t header_bytes = 9;  // Start byte to crc16.
constexpr std::size_t checksum_bytes = 4;
constexpr std::uint16_t crc16_start = 0x4C49;
constexpr std::uint32_t crc32_start = 0x564F580AU ^ 0xFFFFFFFFU;

template <class Register>
constexpr std::array<Register, 256> reflected_crc_table(Register polynomial) {
  std::array<Register, 256> table{};
  for (unsigned byte = 0; byte < 256; ++byte) {
    auto value = static_cast<Register>(byte);
    for (int bit = 0; bit < 8; ++bit) {
      const bool carry = (value & 1U) != 0;
      value = static_cast<Register>(value >> 1U);
      if (carry) value = static_cast<Register>(value ^ polynomial);
    }
    table[byte] = value;
  }
  return table;
}

constexpr auto crc16_table = reflected_crc_table<std::uint16_t>(0x8408);
constexpr auto crc32_table = reflected_crc_table<std::uint32_t>(0xEDB88320U);

Error frame_error(std::string what, std::size_t offset) {
  return input_error(std::move(what), "control frame, offset " + std::to_string(offset));
}

}  // namespace

std::uint16_t crc16(ByteView bytes) {
  std::uint16_t value = crc16_start;
  for (const std::uint8_t byte : bytes) {
    value = static_cast<std::uint16_t>(crc16_table[(value ^ byte) & 0xFFU] ^ (value >> 8U));
  }
  return value;
}

std::uint32_t crc32(ByteView bytes) {
  std::uint32_t value = crc32_start;
  for (const std::uint8_t byte : bytes) value = crc32_table[(value ^ byte) & 0xFFU] ^ (value >> 8U);
  return value ^ 0xFFFFFFFFU;
}

Expected<ControlFrame> parse_control_frame(ByteView datagram) {
  if (datagram.size() < kMinFrameBytes) return frame_error("shorter than 15 bytes", datagram.size());
  ByteReader reader(datagram);
  if (reader.read<std::uint8_t>() != start_byte) return frame_error("does not start with 0xAA", 0);
  if (reader.read<std::uint8_t>() != protocol_version) return frame_error("the protocol version is not 1", 1);
  const std::size_t length = reader.read<std::uint16_t>();
  if (length < kMinFrameBytes || length > datagram.size() || length > kMaxFrameBytes) {
    return frame_error("claims " + std::to_string(length) + " bytes, the datagram has " +
                           std::to_string(datagram.size()) + " (15 to 1400 are possible)",
                       2);
  }
  const auto type = reader.read<std::uint8_t>();
  ControlFrame frame;
  frame.seq = reader.read<std::uint16_t>();
  if (reader.read<std::uint16_t>() != crc16(datagram.first(header_bytes - 2))) {
    return frame_error("the checksum of the header is wrong", 7);
  }
  const auto set = reader.read<std::uint8_t>();
  frame.id = reader.read<std::uint8_t>();
  frame.payload = reader.take(length - kMinFrameBytes);
  if (reader.read<std::uint32_t>() != crc32(datagram.first(length - checksum_bytes))) {
    return frame_error("the checksum of the frame is wrong", length - checksum_bytes);
  }
  if (type > static_cast<std::uint8_t>(FrameType::message)) return frame_error("unknown frame type", 4);
  if (set > static_cast<std::uint8_t>(CommandSet::hub)) return frame_error("unknown command set", 9);
  frame.type = static_cast<FrameType>(type);
  frame.set = static_cast<CommandSet>(set);
  return frame;
}

std::vector<std::uint8_t> make_control_frame(const ControlFrame& frame) {
  const std::size_t length = kMinFrameBytes + frame.payload.size();
  RIGCAL_ASSERT(length <= kMaxFrameBytes, "control frame of " + std::to_string(length) + " bytes");
  std::vector<std::uint8_t> bytes;
  bytes.reserve(length);
  ByteWriter writer(bytes);
  writer.write(start_byte);
  writer.write(protocol_version);
  writer.write(static_cast<std::uint16_t>(length));
  writer.write(static_cast<std::uint8_t>(frame.type));
  writer.write(frame.seq);
  writer.write(crc16(bytes));
  writer.write(static_cast<std::uint8_t>(frame.set));
  writer.write(frame.id);
  writer.write_bytes(frame.payload);
  writer.write(crc32(bytes));
  return bytes;
}

}  // namespace rigcal::livox
