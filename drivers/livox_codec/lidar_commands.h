#pragma once

#include "drivers/livox_codec/command_shapes.h"

/// Payloads of command set 1: what a LiDAR is told, directly connected.
namespace rigcal::livox {

enum class PowerMode : std::uint8_t { normal = 1, power_saving = 2, standby = 3 };
using SetPowerModeRequest = ValueRequest<Command::set_power_mode, PowerMode>;
using SetPowerModeAck = PlainAck<Command::set_power_mode>;

using WriteExtrinsicsRequest = ValueRequest<Command::write_extrinsics, StoredExtrinsics>;
using WriteExtrinsicsAck = PlainAck<Command::write_extrinsics>;
using ReadExtrinsicsRequest = EmptyRequest<Command::read_extrinsics>;
using ReadExtrinsicsAck = ValueAck<Command::read_extrinsics, StoredExtrinsics>;

/// Suppression of rain and fog; Mid-40 only.
using RainSuppressionRequest = ValueRequest<Command::rain_suppression, Switch>;
using RainSuppressionAck = PlainAck<Command::rain_suppression>;

using SetFanRequest = ValueRequest<Command::set_fan, Switch>;
using SetFanAck = PlainAck<Command::set_fan>;
using GetFanRequest = EmptyRequest<Command::get_fan>;
using GetFanAck = ValueAck<Command::get_fan, Switch>;

enum class Echoes : std::uint8_t { first = 0, strongest = 1, dual = 2, triple = 3 };
using SetReturnModeRequest = ValueRequest<Command::set_return_mode, Echoes>;
using SetReturnModeAck = PlainAck<Command::set_return_mode>;
using GetReturnModeRequest = EmptyRequest<Command::get_return_mode>;
using GetReturnModeAck = ValueAck<Command::get_return_mode, Echoes>;

enum class ImuRate : std::uint8_t { off = 0, hz_200 = 1 };
using SetImuRateRequest = ValueRequest<Command::set_imu_rate, ImuRate>;
using SetImuRateAck = PlainAck<Command::set_imu_rate>;
using GetImuRateRequest = EmptyRequest<Command::get_imu_rate>;
using GetImuRateAck = ValueAck<Command::get_imu_rate, ImuRate>;

/// What time it was at the last pulse: sent 10 to 500 ms after each.
struct UtcTime {
  std::int64_t unix_ns = 0;  ///< Microseconds on the wire.
  bool operator==(const UtcTime&) const = default;
};
using SetUtcTimeRequest = ValueRequest<Command::set_utc_time, UtcTime>;
using SetUtcTimeAck = PlainAck<Command::set_utc_time>;

}  // namespace rigcal::livox
