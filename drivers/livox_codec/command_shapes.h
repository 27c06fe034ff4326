#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "drivers/livox_codec/commands.h"

/// What the payloads of the control frames are made of. Each payload is a struct with its `command`, the `type` of its
/// frame, and `fields()` in the order of the wire, from which it is both read and written. Most commands have one of
/// the shapes below.
namespace rigcal::livox {

enum class ReturnCode : std::uint8_t {
  success = 0,
  failure = 1,
  switching = 2,  ///< `set_power_mode` only: the motor spins up or down, the heartbeat tells when it is done.
};

enum class Switch : std::uint8_t { off = 0, on = 1 };

template <Command kCommand>
struct EmptyRequest {
  static constexpr Command command = kCommand;
  static constexpr FrameType type = FrameType::command;
  auto fields() { return std::tie(); }
  bool operator==(const EmptyRequest&) const = default;
};

template <Command kCommand, class Value>
struct ValueRequest {
  static constexpr Command command = kCommand;
  static constexpr FrameType type = FrameType::command;
  Value value{};
  auto fields() { return std::tie(value); }
  bool operator==(const ValueRequest&) const = default;
};

template <Command kCommand>
struct PlainAck {
  static constexpr Command command = kCommand;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  auto fields() { return std::tie(ret); }
  bool operator==(const PlainAck&) const = default;
};

template <Command kCommand, class Value>
struct ValueAck {
  static constexpr Command command = kCommand;
  static constexpr FrameType type = FrameType::ack;
  ReturnCode ret = ReturnCode::success;
  Value value{};
  auto fields() { return std::tie(ret, value); }
  bool operator==(const ValueAck&) const = default;
};

/// Where a sensor is mounted, as it can be stored in the device: R = Rz(yaw) Ry(pitch) Rx(roll), p' = R p + t. A LiDAR
/// does not apply it to its points.
struct StoredExtrinsics {
  float roll_deg = 0.0F;
  float pitch_deg = 0.0F;
  float yaw_deg = 0.0F;
  std::int32_t x_mm = 0;
  std::int32_t y_mm = 0;
  std::int32_t z_mm = 0;
  auto fields() { return std::tie(roll_deg, pitch_deg, yaw_deg, x_mm, y_mm, z_mm); }
  bool operator==(const StoredExtrinsics&) const = default;
};

using FirmwareVersion = std::array<std::uint8_t, 4>;

}  // namespace rigcal::livox
