#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "apps/cameras/camera_recorder.h"
#include "apps/capture/disk_watch.h"
#include "apps/capture/live_stops.h"
#include "core/turntable/capture_machine.h"
#include "drivers/livox/device/driver.h"
#include "drivers/trigger/trigger.h"

namespace rigcal {

/// A LiDAR that sends sends hundreds of packets a second.
constexpr std::int64_t longest_silence_ns = 2'000'000'000;

/// "eth0 192.168.1.5", as all that is told of a capture calls it.
[[nodiscard]] inline std::string name_of(const net::Interface& interface) {
  return interface.name + " " + to_string(interface.ip);
}

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
  CaptureProgress progress;                       ///< State, stops that count, what is awaited.
  std::vector<Stop> stops;                        ///< Complete ones, in order; also those that do not count.
  LiveStopStatus live;                            ///< The rest that goes on.
  std::optional<double> table_deg;                ///< Where a table that turns itself says it is.
  std::optional<DiskRoom> disk;
  double worst_wait_s = 0.0;               ///< Of a packet, from its arrival to the file.
  double worst_write_s = 0.0;              ///< Of the disk, to take what it was given.
  std::vector<std::string> stuck_threads;  ///< Threads of the program that do not move, and since when.
  std::uint64_t events = 0;                ///< That were ever told of.
  std::vector<std::string> news;           ///< The last things that happened, each with its time; the newest last.
};

}  // namespace rigcal
