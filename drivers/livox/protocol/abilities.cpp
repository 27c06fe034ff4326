#include "drivers/livox/protocol/abilities.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <type_traits>

namespace rigcal::livox {
namespace {

// The first two numbers of a firmware from which on a model can do something.
struct Since {
  DeviceType type = DeviceType::avia;
  std::uint8_t major = 0;
  std::uint8_t minor = 0;
};

template <std::size_t size>
bool is_listed(const std::array<Since, size>& table, DeviceType type, const FirmwareVersion& firmware) {
  const auto row = std::find_if(table.begin(), table.end(), [type](const Since& since) { return since.type == type; });
  if (row == table.end()) return false;
  return firmware[0] != row->major ? firmware[0] > row->major : firmware[1] >= row->minor;
}

constexpr std::array<Since, 5> kReboot{{{DeviceType::mid40, 3, 7},
                                        {DeviceType::mid70, 10, 3},
                                        {DeviceType::horizon, 6, 4},
                                        {DeviceType::tele15, 7, 3},
                                        {DeviceType::avia, 11, 6}}};
constexpr std::array<Since, 4> kParameters{
    {{DeviceType::horizon, 6, 11}, {DeviceType::tele15, 7, 9}, {DeviceType::mid70, 10, 3}, {DeviceType::avia, 11, 6}}};
constexpr std::array<Since, 3> kFan{
    {{DeviceType::mid40, 3, 7}, {DeviceType::horizon, 6, 4}, {DeviceType::tele15, 7, 3}}};
constexpr std::array<Since, 4> kReturnMode{
    {{DeviceType::mid70, 10, 3}, {DeviceType::horizon, 6, 4}, {DeviceType::tele15, 7, 3}, {DeviceType::avia, 11, 6}}};
constexpr std::array<Since, 3> kImu{
    {{DeviceType::horizon, 0, 0}, {DeviceType::tele15, 0, 0}, {DeviceType::avia, 0, 0}}};

bool has_key(DeviceType type, std::uint16_t key) {
  switch (static_cast<ParameterKey>(key)) {
    case ParameterKey::high_sensitivity:
      return type == DeviceType::tele15 || type == DeviceType::avia;
    case ParameterKey::scan_pattern:
      return type == DeviceType::avia;
    case ParameterKey::slot_number:
      return type == DeviceType::mid70 || type == DeviceType::avia;
  }
  return false;
}

bool has_parameters_of(DeviceType type, const ControlPayload& request) {
  if (const auto* write = std::get_if<WriteParametersRequest>(&request))
    return std::all_of(write->parameters.begin(), write->parameters.end(),
                       [type](const Parameter& parameter) { return has_key(type, parameter.key); });
  return true;
}

bool is_return_mode_of(DeviceType type, const ControlPayload& request) {
  const auto* mode = std::get_if<SetReturnModeRequest>(&request);
  return mode == nullptr || mode->value != Echoes::triple || type == DeviceType::avia;
}

}  // namespace

Command command_of(const ControlPayload& payload) {
  return std::visit(
      [](const auto& content) {
        using Content = std::decay_t<decltype(content)>;
        if constexpr (std::is_same_v<Content, RawControl>) {
          return livox::command_of(ControlFrame{content.type, 0, content.set, content.id, {}});
        } else if constexpr (std::is_same_v<Content, Broadcast>) {
          return Command::broadcast;
        } else if constexpr (std::is_same_v<Content, Handshake>) {
          return Command::handshake;
        } else {
          return Content::command;
        }
      },
      payload);
}

bool can_do(DeviceType type, const FirmwareVersion& firmware, const ControlPayload& request) {
  switch (command_of(request)) {
    case Command::reboot:
      return is_listed(kReboot, type, firmware);
    case Command::set_utc_time:
      return type != DeviceType::mid40 || is_listed(kReboot, type, firmware);
    case Command::reset_parameters:
      return type != DeviceType::horizon && is_listed(kParameters, type, firmware);
    case Command::write_parameters:
    case Command::read_parameters:
      return is_listed(kParameters, type, firmware) && has_parameters_of(type, request);
    case Command::set_fan:
    case Command::get_fan:
      return is_listed(kFan, type, firmware);
    case Command::set_return_mode:
    case Command::get_return_mode:
      return is_listed(kReturnMode, type, firmware) && is_return_mode_of(type, request);
    case Command::set_imu_rate:
    case Command::get_imu_rate:
      return is_listed(kImu, type, firmware);
    case Command::rain_suppression:
      return type == DeviceType::mid40;
    default:
      return static_cast<unsigned>(command_of(request)) >> 8U != static_cast<unsigned>(CommandSet::hub);
  }
}

bool can_send(const ControlPayload& request) {
  constexpr std::size_t most_keys = 255;
  constexpr std::size_t parameter_head = 4;  // Key and length.
  if (const auto* time = std::get_if<SetUtcTimeRequest>(&request)) {
    constexpr std::int64_t utc_2000_ns = 946'684'800'000'000'000;
    constexpr std::int64_t utc_2256_ns = 9'025'257'600'000'000'000;
    return time->value.unix_ns >= utc_2000_ns && time->value.unix_ns < utc_2256_ns;
  }
  if (const auto* read = std::get_if<ReadParametersRequest>(&request)) return read->keys.size() <= most_keys;
  if (const auto* reset = std::get_if<ResetParametersRequest>(&request)) return reset->keys.size() <= most_keys;
  if (const auto* write = std::get_if<WriteParametersRequest>(&request)) {
    std::size_t left = kMaxFrameBytes - kMinFrameBytes;
    for (const Parameter& parameter : write->parameters) {
      if (parameter.value.size() > left || left - parameter.value.size() < parameter_head) return false;
      left -= parameter.value.size() + parameter_head;
    }
    return !write->parameters.empty();
  }
  return true;
}

std::string firmware_text(const FirmwareVersion& firmware) {
  std::array<char, 16> text{};
  std::snprintf(text.data(), text.size(), "%02u.%02u.%02u.%02u", static_cast<unsigned>(firmware[0]),
                static_cast<unsigned>(firmware[1]), static_cast<unsigned>(firmware[2]),
                static_cast<unsigned>(firmware[3]));
  return text.data();
}

}  // namespace rigcal::livox
