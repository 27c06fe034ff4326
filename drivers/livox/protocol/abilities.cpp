#include "drivers/livox/protocol/abilities.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <type_traits>

namespace rigcal::livox {
namespace {

bool is_since(const std::optional<FirmwareSince>& since, const FirmwareVersion& firmware) {
  if (!since) return false;
  return firmware[0] != since->major ? firmware[0] > since->major : firmware[1] >= since->minor;
}

bool has_key(const LivoxFacts& model, std::uint16_t key) {
  switch (static_cast<ParameterKey>(key)) {
    case ParameterKey::high_sensitivity:
      return model.has_sensitivity;
    case ParameterKey::scan_pattern:
      return model.has_scan_choice;
    case ParameterKey::slot_number:
      return model.has_slot;
  }
  return false;
}

bool has_parameters_of(const LivoxFacts& model, const ControlPayload& request) {
  if (const auto* write = std::get_if<WriteParametersRequest>(&request))
    return std::all_of(write->parameters.begin(), write->parameters.end(),
                       [&](const Parameter& parameter) { return has_key(model, parameter.key); });
  return true;
}

bool is_return_mode_of(const LidarFacts& model, const ControlPayload& request) {
  const auto* mode = std::get_if<SetReturnModeRequest>(&request);
  return mode == nullptr || mode->value != Echoes::triple || model.echoes >= 3;
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
  const LidarFacts& model = facts_of(type);
  const LivoxFacts& livox = model.livox;
  switch (command_of(request)) {
    case Command::reboot:
      return is_since(livox.reboot, firmware);
    case Command::set_utc_time:
      return type != DeviceType::mid40 || is_since(livox.reboot, firmware);
    case Command::reset_parameters:
      return livox.resets_parameters && is_since(livox.parameters, firmware);
    case Command::write_parameters:
    case Command::read_parameters:
      return is_since(livox.parameters, firmware) && has_parameters_of(livox, request);
    case Command::set_fan:
    case Command::get_fan:
      return is_since(livox.fan, firmware);
    case Command::set_return_mode:
    case Command::get_return_mode:
      return is_since(livox.return_mode, firmware) && is_return_mode_of(model, request);
    case Command::set_imu_rate:
    case Command::get_imu_rate:
      return model.has_imu;
    case Command::rain_suppression:
      return livox.suppresses_rain;
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
