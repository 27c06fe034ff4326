#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "drivers/livox_codec/control_frame.h"

namespace rigcal::livox {

/// Every command of the protocol: the set in the high byte, the id in the low one.
enum class Command : std::uint16_t {
  broadcast = 0x0000,
  handshake,
  device_information,
  heartbeat,
  sampling,
  coordinates,
  disconnect,
  abnormal_status,
  set_ip_mode,
  get_ip_mode,
  reboot,
  write_parameters,
  read_parameters,
  reset_parameters,

  set_power_mode = 0x0100,
  write_extrinsics,
  read_extrinsics,
  rain_suppression,
  set_fan,
  get_fan,
  set_return_mode,
  get_return_mode,
  set_imu_rate,
  get_imu_rate,
  set_utc_time,

  hub_list_lidars = 0x0200,
  hub_set_power_mode,
  hub_slot_power,
  hub_write_extrinsics,
  hub_read_extrinsics,
  hub_lidar_status,
  hub_use_extrinsics,
  hub_rain_suppression,
  hub_slot_power_status,
  hub_set_fan,
  hub_get_fan,
  hub_set_return_mode,
  hub_get_return_mode,
  hub_set_imu_rate,
  hub_get_imu_rate,
};

/// A value that is none of the enumerators where the frame's id is not known.
[[nodiscard]] constexpr Command command_of(const ControlFrame& frame) {
  return static_cast<Command>(static_cast<unsigned>(frame.set) << 8U | frame.id);
}

[[nodiscard]] constexpr ControlFrame frame_of(Command command, FrameType type, std::uint16_t seq, ByteView payload) {
  const auto code = static_cast<unsigned>(command);
  return {type, seq, static_cast<CommandSet>(code >> 8U), static_cast<std::uint8_t>(code & 0xFFU), payload};
}

/// The enumerator's name; "general_0x1f", "lidar_0x..", "hub_0x.." for others.
[[nodiscard]] std::string command_name(Command command);

/// The command of that name.
[[nodiscard]] std::optional<Command> find_command(const std::string& name);

/// True for what the host asks of the device: commands, and the handshake that some hosts send as `FrameType::ack`.
[[nodiscard]] bool is_request(const ControlFrame& frame);

/// What a frame is, for counting and logs: the command's name, with "_ack" behind it for an answer.
[[nodiscard]] std::string frame_name(const ControlFrame& frame);

}  // namespace rigcal::livox
