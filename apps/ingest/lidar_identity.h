#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>

#include "core/rig/rig.h"

namespace rigcal {

using IpAddress = std::array<std::uint8_t, 4>;
/// Broadcast codes by address, as devices have told them.
using BroadcastCodes = std::map<IpAddress, std::string>;

/// Index of the LiDAR of the rig that has this address, or -1. What a device says of itself (`codes`) counts more than
/// the addresses in the rig file: those are used for devices that said nothing, and for sensors without a code.
[[nodiscard]] int sensor_at(const Rig& rig, const BroadcastCodes& codes, const IpAddress& ip);

/// Index of the LiDAR that the rig file puts at this address, or -1.
[[nodiscard]] int sensor_by_ip(const Rig& rig, const IpAddress& ip);

}  // namespace rigcal
