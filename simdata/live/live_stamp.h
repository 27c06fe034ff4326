#pragma once

#include <span>

#include "simdata/packets/sim_device.h"

namespace rigcal::sim {

/// How the stamps of a rendered packet become those of a live device.
struct LiveTime {
  double speed = 1.0;              ///< The run goes this much faster, and with it the gyro turns faster.
  double earlier_s = 0.0;          ///< True time of the runs before this one.
  std::int64_t boot_stamp_ns = 0;  ///< What the device's clock would read at its last start, had it not restarted.

  /// The live stamp of a rendered one.
  [[nodiscard]] std::int64_t stamp_ns(const DeviceClock& clock, std::int64_t rendered_ns) const;
};

/// The stamp of a sample packet of any bytes that is as long as its header, when it counts from the device's start.
[[nodiscard]] std::int64_t rendered_stamp_ns(std::span<const std::uint8_t> packet);

/// Makes the gyro of an IMU packet turn so many times faster.
void speed_up_gyro(double speed, std::span<std::uint8_t> packet);

}  // namespace rigcal::sim
