#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/records/lidar_models.h"
#include "drivers/livox_codec/commands.h"

namespace rigcal::livox {

/// The type codes of core/records/lidar_models.h, and the Hub's.
enum class DeviceType : std::uint8_t {
  hub = 0,
  mid40 = 1,
  tele15 = 2,
  horizon = 3,
  mid70 = 6,
  avia = 7,
};

/// What a device of this model says that it is; nothing for LiDARs of other makers.
[[nodiscard]] std::optional<DeviceType> device_type(LidarModel model);
/// Of a Hub and of an unknown type: `other`.
[[nodiscard]] LidarModel lidar_model(DeviceType type);
[[nodiscard]] const LidarFacts& facts_of(DeviceType type);
[[nodiscard]] std::string model_name(DeviceType type);

/// UDP port of the host that broadcasts go to, and the device's own port for commands.
constexpr std::uint16_t kDiscoveryPort = 55000;
constexpr std::uint16_t kDevicePort = 65000;
/// Where point and IMU packets come from.
constexpr std::uint16_t kPointSourcePort = 60001;
constexpr std::uint16_t kImuSourcePort = 60003;

/// What a device without a host says once a second (message 0/0).
struct Broadcast {
  std::string broadcast_code;  ///< 15 printable characters: 14 of the serial number and a digit.
  DeviceType type = DeviceType::avia;
  std::uint16_t command_port = 0;  ///< "Reserved" in the vendor's page; real units put 65000 or 0 there. Not used.

  bool operator==(const Broadcast&) const = default;
};

/// How a host takes a device (command 0/1). It is sent by some hosts as `FrameType::ack`.
struct Handshake {
  std::array<std::uint8_t, 4> host_ip{};
  std::uint16_t data_port = 0;
  std::uint16_t command_port = 0;
  std::optional<std::uint16_t> imu_port;  ///< Old firmware is sent none: IMU packets go to `data_port`.

  bool operator==(const Handshake&) const = default;
};

[[nodiscard]] bool is_broadcast(const ControlFrame& frame);
/// True for the request only; its answer has one byte.
[[nodiscard]] bool is_handshake(const ControlFrame& frame);

/// Error: not a broadcast, wrong length, unknown device type, or a code that is not text.
[[nodiscard]] Expected<Broadcast> parse_broadcast(const ControlFrame& frame);
[[nodiscard]] std::vector<std::uint8_t> make_broadcast(const Broadcast& broadcast, std::uint16_t seq);

/// Error: not a handshake request, or neither 8 nor 10 bytes.
[[nodiscard]] Expected<Handshake> parse_handshake(const ControlFrame& frame);
[[nodiscard]] std::vector<std::uint8_t> make_handshake(const Handshake& handshake, std::uint16_t seq,
                                                       FrameType type = FrameType::command);

}  // namespace rigcal::livox
