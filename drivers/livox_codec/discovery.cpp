#include "drivers/livox_codec/discovery.h"

#include "drivers/livox_codec/wire_fields.h"

namespace rigcal::livox {
namespace {

constexpr std::size_t kBroadcastBytes = 19;
constexpr std::size_t kHandshakeBytes = 10;
constexpr std::size_t kOldHandshakeBytes = 8;

bool is_device_type(std::uint8_t type) { return type <= 3 || type == 6 || type == 7; }

}  // namespace

std::string model_name(DeviceType type) {
  switch (type) {
    case DeviceType::hub:
      return "Hub";
    case DeviceType::mid40:
      return "Mid-40";
    case DeviceType::tele15:
      return "Tele-15";
    case DeviceType::horizon:
      return "Horizon";
    case DeviceType::mid70:
      return "Mid-70";
    case DeviceType::avia:
      return "Avia";
  }
  return "device type " + std::to_string(static_cast<int>(type));
}

bool has_imu(DeviceType type) {
  return type == DeviceType::avia || type == DeviceType::horizon || type == DeviceType::tele15;
}

double shots_per_second(DeviceType type) {
  return type == DeviceType::mid40 || type == DeviceType::mid70 ? 100'000.0 : 240'000.0;
}

bool is_broadcast(const ControlFrame& frame) {
  return frame.type == FrameType::message && command_of(frame) == Command::broadcast;
}

bool is_handshake(const ControlFrame& frame) {
  return frame.type != FrameType::message && command_of(frame) == Command::handshake &&
         (frame.payload.size() == kHandshakeBytes || frame.payload.size() == kOldHandshakeBytes);
}

Expected<Broadcast> parse_broadcast(const ControlFrame& frame) {
  if (!is_broadcast(frame)) return input_error("not a broadcast", "control frame");
  if (frame.payload.size() != kBroadcastBytes) {
    return input_error("has a payload of " + std::to_string(frame.payload.size()) + " bytes instead of 19",
                       "broadcast");
  }
  ByteReader reader(frame.payload);
  std::optional<std::string> code = read_broadcast_code(reader);
  if (!code) return input_error("the broadcast code is not 15 printable characters", "broadcast");
  const auto type = reader.read<std::uint8_t>();
  if (!is_device_type(type)) return input_error("unknown device type " + std::to_string(type), "broadcast");
  Broadcast broadcast;
  broadcast.broadcast_code = std::move(*code);
  broadcast.type = static_cast<DeviceType>(type);
  broadcast.command_port = reader.read<std::uint16_t>();
  return broadcast;
}

std::vector<std::uint8_t> make_broadcast(const Broadcast& broadcast, std::uint16_t seq) {
  std::vector<std::uint8_t> payload;
  ByteWriter writer(payload);
  write_broadcast_code(broadcast.broadcast_code, writer);
  writer.write(static_cast<std::uint8_t>(broadcast.type));
  writer.write(broadcast.command_port);
  return make_control_frame(frame_of(Command::broadcast, FrameType::message, seq, payload));
}

Expected<Handshake> parse_handshake(const ControlFrame& frame) {
  if (!is_handshake(frame)) return input_error("not a handshake request of 8 or 10 bytes", "control frame");
  ByteReader reader(frame.payload);
  Handshake handshake;
  for (std::uint8_t& part : handshake.host_ip) part = reader.read<std::uint8_t>();
  handshake.data_port = reader.read<std::uint16_t>();
  handshake.command_port = reader.read<std::uint16_t>();
  if (reader.left() > 0) handshake.imu_port = reader.read<std::uint16_t>();
  return handshake;
}

std::vector<std::uint8_t> make_handshake(const Handshake& handshake, std::uint16_t seq, FrameType type) {
  std::vector<std::uint8_t> payload;
  ByteWriter writer(payload);
  writer.write_bytes(handshake.host_ip);
  writer.write(handshake.data_port);
  writer.write(handshake.command_port);
  if (handshake.imu_port) writer.write(*handshake.imu_port);
  return make_control_frame(frame_of(Command::handshake, type, seq, payload));
}

}  // namespace rigcal::livox
