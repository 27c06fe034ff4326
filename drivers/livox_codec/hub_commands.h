#pragma once

#include <optional>

#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/general_commands.h"
#include "drivers/livox_codec/lidar_commands.h"

/// Payloads of command set 2: what a Hub is told. LiDARs behind it are named by their broadcast codes of 15 characters.
namespace rigcal::livox {

/// What one LiDAR shall be set to.
template <class Value>
struct HubSetting {
  std::string code;
  Value value{};
  auto fields() { return std::tie(code, value); }
  bool operator==(const HubSetting&) const = default;
};

struct HubOutcome {
  ReturnCode ret = ReturnCode::success;
  std::string code;
  auto fields() { return std::tie(ret, code); }
  bool operator==(const HubOutcome&) const = default;
};

template <class Value>
struct HubReading {
  ReturnCode ret = ReturnCode::success;
  std::string code;
  Value value{};
  auto fields() { return std::tie(ret, code, value); }
  bool operator==(const HubReading&) const = default;
};

template <Command kCommand, class Value>
using HubSetRequest = ValueRequest<kCommand, std::vector<HubSetting<Value>>>;
template <Command kCommand>
using HubSetAck = ValueAck<kCommand, std::vector<HubOutcome>>;
template <Command kCommand>
using HubGetRequest = ValueRequest<kCommand, std::vector<std::string>>;
template <Command kCommand, class Value>
using HubGetAck = ValueAck<kCommand, std::vector<HubReading<Value>>>;

/// A LiDAR behind a Hub.
struct HubLidar {
  std::string code;
  DeviceType type = DeviceType::mid40;
  FirmwareVersion version{};
  std::uint8_t slot = 1;  ///< 1 to 9
  std::uint8_t id = 1;    ///< 1 to 3
  auto fields() { return std::tie(code, type, version, slot, id); }
  bool operator==(const HubLidar&) const = default;
};
using HubListLidarsRequest = EmptyRequest<Command::hub_list_lidars>;
using HubListLidarsAck = ValueAck<Command::hub_list_lidars, std::vector<HubLidar>>;

using HubSetPowerModeRequest = HubSetRequest<Command::hub_set_power_mode, PowerMode>;
using HubSetPowerModeAck = HubSetAck<Command::hub_set_power_mode>;

struct HubSlotPowerRequest {
  static constexpr Command command = Command::hub_slot_power;
  static constexpr FrameType type = FrameType::command;
  std::uint8_t slot = 1;
  Switch power = Switch::off;
  auto fields() { return std::tie(slot, power); }
  bool operator==(const HubSlotPowerRequest&) const = default;
};
using HubSlotPowerAck = PlainAck<Command::hub_slot_power>;

using HubWriteExtrinsicsRequest = HubSetRequest<Command::hub_write_extrinsics, StoredExtrinsics>;
using HubWriteExtrinsicsAck = HubSetAck<Command::hub_write_extrinsics>;
/// The vendor's software sends no list at all; those of every LiDAR are meant then.
using HubReadExtrinsicsRequest = ValueRequest<Command::hub_read_extrinsics, std::optional<std::vector<std::string>>>;
using HubReadExtrinsicsAck = HubGetAck<Command::hub_read_extrinsics, StoredExtrinsics>;

struct HubLidarStatus {
  std::string code;
  WorkState state = WorkState::initialising;
  std::uint8_t features = 0;             ///< As in `HeartbeatAck`.
  std::uint32_t progress_or_status = 0;  ///< As in `HeartbeatAck`.
  auto fields() { return std::tie(code, state, features, progress_or_status); }
  bool operator==(const HubLidarStatus&) const = default;
};
using HubLidarStatusRequest = EmptyRequest<Command::hub_lidar_status>;
using HubLidarStatusAck = ValueAck<Command::hub_lidar_status, std::vector<HubLidarStatus>>;

/// Whether the Hub applies the stored extrinsics to the points.
using HubUseExtrinsicsRequest = ValueRequest<Command::hub_use_extrinsics, Switch>;
using HubUseExtrinsicsAck = PlainAck<Command::hub_use_extrinsics>;

using HubRainSuppressionRequest = HubSetRequest<Command::hub_rain_suppression, Switch>;
using HubRainSuppressionAck = HubSetAck<Command::hub_rain_suppression>;

/// A bit a slot.
using HubSlotPowerStatusRequest = EmptyRequest<Command::hub_slot_power_status>;
using HubSlotPowerStatusAck = ValueAck<Command::hub_slot_power_status, std::uint16_t>;

using HubSetFanRequest = HubSetRequest<Command::hub_set_fan, Switch>;
using HubSetFanAck = HubSetAck<Command::hub_set_fan>;
using HubGetFanRequest = HubGetRequest<Command::hub_get_fan>;
using HubGetFanAck = HubGetAck<Command::hub_get_fan, Switch>;

using HubSetReturnModeRequest = HubSetRequest<Command::hub_set_return_mode, Echoes>;
using HubSetReturnModeAck = HubSetAck<Command::hub_set_return_mode>;
using HubGetReturnModeRequest = HubGetRequest<Command::hub_get_return_mode>;
using HubGetReturnModeAck = HubGetAck<Command::hub_get_return_mode, Echoes>;

using HubSetImuRateRequest = HubSetRequest<Command::hub_set_imu_rate, ImuRate>;
using HubSetImuRateAck = HubSetAck<Command::hub_set_imu_rate>;
using HubGetImuRateRequest = HubGetRequest<Command::hub_get_imu_rate>;
using HubGetImuRateAck = HubGetAck<Command::hub_get_imu_rate, ImuRate>;

}  // namespace rigcal::livox
