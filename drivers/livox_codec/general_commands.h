#pragma once

#include <optional>

#include "drivers/livox_codec/command_shapes.h"

/// Payloads of command set 0, which every device knows. Broadcast and handshake are in discovery.h.
namespace rigcal::livox {

using HandshakeAck = PlainAck<Command::handshake>;

using DeviceInformationRequest = EmptyRequest<Command::device_information>;
using DeviceInformationAck = ValueAck<Command::device_information, FirmwareVersion>;

enum class WorkState : std::uint8_t {
  initialising = 0,  ///< The motor spins up, the device tests itself.
  normal = 1,
  power_saving = 2,
  standby = 3,
  error = 4,
};

using HeartbeatRequest = EmptyRequest<Command::heartbeat>;

struct HeartbeatAck {
  static constexpr Command command = Command::heartbeat;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  WorkState state = WorkState::initialising;
  std::uint8_t features = 0;  ///< Bit 0: rain and fog suppression is on.
  /// Percent done while initialising, otherwise the status word (`decode_status`, a Hub's: `decode_hub_status`).
  std::uint32_t progress_or_status = 0;
  auto fields() { return std::tie(ret, state, features, progress_or_status); }
  bool operator==(const HeartbeatAck&) const = default;
};

enum class Sampling : std::uint8_t { stop = 0, start = 1 };
using SamplingRequest = ValueRequest<Command::sampling, Sampling>;
using SamplingAck = PlainAck<Command::sampling>;

enum class Coordinates : std::uint8_t { cartesian = 0, spherical = 1 };
using CoordinatesRequest = ValueRequest<Command::coordinates, Coordinates>;
using CoordinatesAck = PlainAck<Command::coordinates>;

using DisconnectRequest = EmptyRequest<Command::disconnect>;
using DisconnectAck = PlainAck<Command::disconnect>;

/// What a device sends up to ten times a second while something is wrong.
struct AbnormalStatus {
  static constexpr Command command = Command::abnormal_status;
  static constexpr FrameType type = FrameType::message;
  std::uint32_t status = 0;  ///< `decode_status`; a Hub's: `decode_hub_status`.
  auto fields() { return std::tie(status); }
  bool operator==(const AbnormalStatus&) const = default;
};

enum class IpMode : std::uint8_t { dynamic = 0, fixed = 1 };
using Ipv4 = std::array<std::uint8_t, 4>;  ///< Bytes in dotted order.

struct Subnet {
  Ipv4 mask{};
  Ipv4 gateway{};
  auto fields() { return std::tie(mask, gateway); }
  bool operator==(const Subnet&) const = default;
};

/// Takes effect when the device has been rebooted.
struct SetIpModeRequest {
  static constexpr Command command = Command::set_ip_mode;
  static constexpr FrameType type = FrameType::command;
  IpMode mode = IpMode::dynamic;
  Ipv4 ip{};
  std::optional<Subnet> subnet;  ///< Old firmware is sent none (Hub, Mid-40).
  auto fields() { return std::tie(mode, ip, subnet); }
  bool operator==(const SetIpModeRequest&) const = default;
};
using SetIpModeAck = PlainAck<Command::set_ip_mode>;

using GetIpModeRequest = EmptyRequest<Command::get_ip_mode>;

struct GetIpModeAck {
  static constexpr Command command = Command::get_ip_mode;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  IpMode mode = IpMode::dynamic;
  Ipv4 ip{};
  std::optional<Subnet> subnet;  ///< A Mid-40 tells none.
  auto fields() { return std::tie(ret, mode, ip, subnet); }
  bool operator==(const GetIpModeAck&) const = default;
};

/// The value is the delay in milliseconds.
using RebootRequest = ValueRequest<Command::reboot, std::uint16_t>;
using RebootAck = PlainAck<Command::reboot>;

/// The keys that are known; a device answers others with `ParameterError::key_not_supported`.
enum class ParameterKey : std::uint16_t {
  high_sensitivity = 1,  ///< One byte: 0 off, 1 on.
  scan_pattern = 2,      ///< One byte: 0 non-repetitive, 1 repetitive.
  slot_number = 3,       ///< One byte.
};

enum class ParameterError : std::uint8_t {
  none = 0,
  key_not_supported = 1,
  failed = 2,
  not_writable_now = 3,
  wrong_value = 4,
  wrong_length = 5,
  buffer_too_small = 6,
  wrong_count = 7,
};

struct Parameter {
  std::uint16_t key = 0;
  std::vector<std::uint8_t> value;
  bool operator==(const Parameter&) const = default;
};

struct WriteParametersRequest {
  static constexpr Command command = Command::write_parameters;
  static constexpr FrameType type = FrameType::command;
  std::vector<Parameter> parameters;  ///< At least one.
  auto fields() { return std::tie(parameters); }
  [[nodiscard]] const char* mistake() const { return parameters.empty() ? "names no parameter" : nullptr; }
  bool operator==(const WriteParametersRequest&) const = default;
};

/// How writing or resetting parameters went.
template <Command kCommand>
struct ParametersAck {
  static constexpr Command command = kCommand;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  std::uint16_t error_key = 0;
  ParameterError error = ParameterError::none;
  auto fields() { return std::tie(ret, error_key, error); }
  bool operator==(const ParametersAck&) const = default;
};
using WriteParametersAck = ParametersAck<Command::write_parameters>;

struct ReadParametersRequest {
  static constexpr Command command = Command::read_parameters;
  static constexpr FrameType type = FrameType::command;
  std::vector<std::uint16_t> keys;
  auto fields() { return std::tie(keys); }
  bool operator==(const ReadParametersRequest&) const = default;
};

struct ReadParametersAck {
  static constexpr Command command = Command::read_parameters;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  std::uint16_t error_key = 0;
  ParameterError error = ParameterError::none;
  std::vector<Parameter> parameters;
  auto fields() { return std::tie(ret, error_key, error, parameters); }
  bool operator==(const ReadParametersAck&) const = default;
};

enum class ParameterReset : std::uint8_t { all = 0, listed = 1 };

struct ResetParametersRequest {
  static constexpr Command command = Command::reset_parameters;
  static constexpr FrameType type = FrameType::command;
  ParameterReset scope = ParameterReset::all;
  std::vector<std::uint16_t> keys;
  /// A zero that the vendor's software puts behind an empty list.
  std::optional<std::uint16_t> filler;
  auto fields() { return std::tie(scope, keys, filler); }
  [[nodiscard]] const char* mistake() const {
    return filler && (!keys.empty() || *filler != 0) ? "has more keys than it counts" : nullptr;
  }
  bool operator==(const ResetParametersRequest&) const = default;

  /// As the vendor's software asks for it.
  static ResetParametersRequest all() { return {ParameterReset::all, {}, std::uint16_t{0}}; }
};
using ResetParametersAck = ParametersAck<Command::reset_parameters>;

}  // namespace rigcal::livox
