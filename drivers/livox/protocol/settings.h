#pragma once

#include <optional>
#include <string>
#include <vector>

#include "drivers/livox_codec/control_payload.h"

namespace rigcal::livox {

/// How a device is to work. What is not set stays as the device has it.
struct DeviceSettings {
  std::optional<Coordinates> coordinates;
  std::optional<Echoes> return_mode;
  std::optional<ImuRate> imu_rate;
  std::optional<Switch> high_sensitivity;
  std::optional<Switch> repetitive_scan;
  std::optional<Switch> fan;
  std::optional<Switch> rain_suppression;
  std::optional<StoredExtrinsics> extrinsics;
};

/// The requests for this, in the order in which devices want them.
[[nodiscard]] std::vector<ControlPayload> setup_requests(const DeviceSettings& settings);

/// What one of these sets, in the words of a rig file where that has some: "return_mode: dual".
[[nodiscard]] std::string setting_text(const ControlPayload& request);

/// Whether devices that do not know the setting work as it wants them to all the same: they give one echo, have no IMU,
/// scan without a pattern.
[[nodiscard]] bool is_met_unknown(const ControlPayload& request);

}  // namespace rigcal::livox
