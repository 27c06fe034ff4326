#include "drivers/livox_codec/discovery.h"

#include <algorithm>

#include "drivers/livox_codec/wire_fields.h"

namespace rigcal::livox {
namespace {

constexpr std::size_t broadcast_bytes = 19;
constexpr std::size_t handshake_bytes = 10;
constexpr std::size_t old_handshake_bytes = 8;

constexpr std::uint8_t code_of(DeviceType type) { return static_cast<std::uint8_t>(type); }

bool is_device_type(DeviceType type) { return type == DeviceType::hub || lidar_model(type) != LidarModel::other; }

}  // namespace

std::optional<DeviceType> device_type(LidarModel model) {
  const LidarFacts& facts = rigcal::facts_of(model);
  return facts.is_livox() ? std::optional(static_cast<DeviceType>(facts.livox.type_code)) : std::nullopt;
}

LidarModel lidar_model(DeviceType type) {
  const auto rows = lidar_models();
  const auto row = std::find_if(rows.begin(), rows.end(),
                                [&](const LidarFacts& facts) { return facts.livox.type_code == code_of(type); });
  return type == DeviceType::hub || row == rows.end() ? LidarModel::other : row->model;
}

const LidarFacts& facts_of(DeviceType type) { return rigcal::facts_of(lidar_model(type)); }

std::string model_name(DeviceType type) {
  if (type == DeviceType::hub) return "Hub";
  const LidarFacts& facts = facts_of(type);
  return facts.model == LidarModel::other ? "device type " + std::to_string(code_of(type)) : facts.name;
}

bool is_broadcast(const ControlFrame& frame) {
  return frame.type == FrameType::message && command_of(frame) == Command::broadcast;
}

bool is_handshake(const ControlFrame& frame) {
  return frame.type != FrameType::message && command_of(frame) == Command::handshake &&
         (frame.payload.size() == handshake_bytes || frame.payload.size() == old_handshake_bytes);
}

Expected<Broadcast> parse_broadcast(const ControlFrame& frame) {
  if (!is_broadcast(frame)) return input_error("not a broadcast", "control frame");
  if (frame.payload.size() != broadcast_bytes) {
    return input_error("has a payload of " + std::to_string(frame.payload.size()) + " bytes instead of 19",
                       "broadcast");
  }
  ByteReader reader(frame.payload);
  std::optional<std::string> code = read_broadcast_code(reader);
  if (!code) return input_error("the broadcast code is not 15 printable characters", "broadcast");
  const auto type = static_cast<DeviceType>(reader.read<std::uint8_t>());
  if (!is_device_type(type)) return input_error("unknown " + model_name(type), "broadcast");
  Broadcast broadcast;
  broadcast.broadcast_code = std::move(*code);
  broadcast.type = type;
  broadcast.command_port = reader.read<std::uint16_t>();
  return broadcast;
}

std::vector<std::uint8_t> make_broadcast(const Broadcast& broadcast, std::uint16_t seq) {
  std::vector<std::uint8_t> payload;
  ByteWriter writer(payload);
  write_broadcast_code(broadcast.broadcast_code, writer);
  writer.write(code_of(broadcast.type));
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
