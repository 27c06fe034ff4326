#include "drivers/livox_codec/commands.h"

#include <array>
#include <cstdio>

#include "drivers/livox_codec/discovery.h"

namespace rigcal::livox {
namespace {

// In the order of the enumerators, a row a set.
constexpr std::array<const char*, 14> general_names{
    "broadcast",   "handshake",        "device_information", "heartbeat",       "sampling",
    "coordinates", "disconnect",       "abnormal_status",    "set_ip_mode",     "get_ip_mode",
    "reboot",      "write_parameters", "read_parameters",    "reset_parameters"};
constexpr std::array<const char*, 11> lidar_names{
    "set_power_mode",  "write_extrinsics", "read_extrinsics", "rain_suppression", "set_fan",     "get_fan",
    "set_return_mode", "get_return_mode",  "set_imu_rate",    "get_imu_rate",     "set_utc_time"};
constexpr std::array<const char*, 15> hub_names{
    "hub_list_lidars",  "hub_set_power_mode",  "hub_slot_power",       "hub_write_extrinsics",  "hub_read_extrinsics",
    "hub_lidar_status", "hub_use_extrinsics",  "hub_rain_suppression", "hub_slot_power_status", "hub_set_fan",
    "hub_get_fan",      "hub_set_return_mode", "hub_get_return_mode",  "hub_set_imu_rate",      "hub_get_imu_rate"};

template <std::size_t size>
const char* name_in(const std::array<const char*, size>& names, unsigned id) {
  return id < size ? names[id] : nullptr;
}

}  // namespace

std::string command_name(Command command) {
  const auto code = static_cast<unsigned>(command);
  const unsigned id = code & 0xFFU;
  const char* name = nullptr;
  const char* set = "set";
  switch (static_cast<CommandSet>(code >> 8U)) {
    case CommandSet::general:
      name = name_in(general_names, id);
      set = "general";
      break;
    case CommandSet::lidar:
      name = name_in(lidar_names, id);
      set = "lidar";
      break;
    case CommandSet::hub:
      name = name_in(hub_names, id);
      set = "hub";
      break;
  }
  if (name != nullptr) return name;
  std::array<char, 24> text{};
  std::snprintf(text.data(), text.size(), "%s_0x%02x", set, id);
  return text.data();
}

std::optional<Command> find_command(const std::string& name) {
  for (unsigned set = 0; set <= static_cast<unsigned>(CommandSet::hub); ++set) {
    for (unsigned id = 0; id < general_names.size() + hub_names.size(); ++id) {
      const auto command = static_cast<Command>(set << 8U | id);
      if (command_name(command) == name && name.find("_0x") == std::string::npos) return command;
    }
  }
  return std::nullopt;
}

bool is_request(const ControlFrame& frame) { return frame.type == FrameType::command || is_handshake(frame); }

std::string frame_name(const ControlFrame& frame) {
  const std::string name = command_name(command_of(frame));
  return frame.type == FrameType::ack && !is_handshake(frame) ? name + "_ack" : name;
}

}  // namespace rigcal::livox
