#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/camera_recorder.h"
#include "apps/live_stops.h"
#include "drivers/livox/device/driver.h"
#include "drivers/trigger/trigger.h"

namespace rigcal {

/// How a LiDAR of a running capture does.
struct CaptureDevice {
  std::string sensor;
  livox::DeviceReport report;
  double packets_per_s = 0.0;  ///< Since the last look; points and IMU.
  std::uint64_t expected = 0;  ///< Packets that it has sent, by their stamps.
  std::uint64_t lost = 0;      ///< Of these: not here. By their stamps, wherever they got lost.
  double drift_ppm = 0.0;      ///< Of its clock against the session's.
};

/// A plain picture of a running capture, for whoever shows it: the terminal, a page.
struct CaptureStatus {
  double seconds = 0.0;
  std::vector<CaptureDevice> devices;
  std::vector<CaptureCamera> cameras;
  std::optional<trigger::TriggerReport> trigger;  ///< Of the rig's own lines.
  std::uint64_t bytes = 0;                        ///< On the disk, without images.
  std::vector<Stop> stops;                        ///< Complete ones, in order.
  LiveStopStatus live;                            ///< The rest that goes on.
};

}  // namespace rigcal
