#pragma once

#include <optional>
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

}  // namespace rigcal::livox
