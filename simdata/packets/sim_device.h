#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/seconds.h"
#include "core/rig/rig.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/general_commands.h"
#include "drivers/livox_codec/sample_packet.h"

namespace rigcal::sim {

/// A device's clock: free running since its start, too fast or too slow. True time is seconds since sampling began.
struct DeviceClock {
  std::int64_t stamp_at_zero_ns = 0;  ///< Reading at true time 0.
  double drift = 0.0;                 ///< Seconds gained in a second.

  [[nodiscard]] double true_s(std::int64_t stamp_ns) const {
    return seconds_of_ns(stamp_ns - stamp_at_zero_ns) / (1.0 + drift);
  }
  [[nodiscard]] std::int64_t stamp_ns(double true_seconds) const;
};

/// A simulated LiDAR as the network sees it.
struct SimDevice {
  int sensor = 0;  ///< Index in the rig.
  livox::Broadcast broadcast;
  livox::DataType points = livox::DataType::cartesian;
  bool nearest_only = false;  ///< Single return: the first echo, else the strongest.
  std::uint8_t lidar_id = 1;
  bool has_imu = false;
  Endpoint point_source;
  Endpoint imu_source;
  Endpoint data_sink;  ///< Of the host; IMU packets go to the same port, as the vendor's software asks for.
  DeviceClock clock;
  std::int64_t packet_interval_ns = 0;  ///< In the device's time.
};

constexpr double imu_interval_s = 0.005;

/// Another data type of its points, with the interval between packets that belongs to it.
void set_data_type(SimDevice& device, livox::DataType type);

/// A broadcast code for a device that has none, with the first letters of its model's real ones; `number` from 0 to
/// 9999.
[[nodiscard]] std::string made_up_code(livox::DeviceType type, int number);

constexpr double usual_clock_drift_ppm = 50.0;

/// The devices of a rig: address and code from the rig file (a code is made up where there is none), data type from its
/// `coordinates` and `return_mode`, clocks drawn: started 20 s to 10 min ago, up to `clock_drift_ppm` off. Errors: a
/// LiDAR that is none of Livox or has no `ip`, two with the same one, a return mode that the model does not have.
[[nodiscard]] Expected<std::vector<SimDevice>> make_devices(const Rig& rig, std::uint64_t seed,
                                                            double clock_drift_ppm = usual_clock_drift_ppm);

/// Where devices beside that host broadcast to: the host itself on loopback, which has no broadcasts.
[[nodiscard]] Endpoint broadcast_address(const livox::Ipv4& host, std::uint16_t port = livox::kDiscoveryPort);

/// The address of the host for this rig: `lidar.host_ip`, or where that is `auto` 127.0.0.1 beside loopback devices and
/// .5 in the first device's network.
[[nodiscard]] Expected<std::array<std::uint8_t, 4>> host_address(const Rig& rig);

}  // namespace rigcal::sim
