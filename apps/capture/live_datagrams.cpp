#include "apps/capture/live_datagrams.h"

namespace rigcal {
namespace {

constexpr std::int64_t wait_ns = 50'000'000;

livox::Echoes echoes_of(ReturnMode mode) {
  switch (mode) {
    case ReturnMode::first:
      return livox::Echoes::first;
    case ReturnMode::strongest:
      return livox::Echoes::strongest;
    case ReturnMode::dual:
      return livox::Echoes::dual;
    case ReturnMode::triple:
      return livox::Echoes::triple;
  }
  return livox::Echoes::strongest;
}

livox::DeviceSettings settings_of(const LidarSettings& lidar) {
  livox::DeviceSettings settings;
  if (lidar.coordinates)
    settings.coordinates = *lidar.coordinates == CoordinateSystem::spherical ? livox::Coordinates::spherical
                                                                             : livox::Coordinates::cartesian;
  if (lidar.return_mode) settings.return_mode = echoes_of(*lidar.return_mode);
  if (lidar.imu) {
    settings.imu_rate = *lidar.imu ? livox::ImuRate::hz_200 : livox::ImuRate::off;
  } else if (facts_of(lidar.model).has_imu) {
    settings.imu_rate = livox::ImuRate::hz_200;  // Stops are found by it.
  }
  if (!lidar.scan_pattern.empty())
    settings.repetitive_scan = lidar.scan_pattern == "repetitive" ? livox::Switch::on : livox::Switch::off;
  return settings;
}

}  // namespace

Expected<livox::DriverOptions> driver_options(const Rig& rig) {
  livox::DriverOptions options;
  options.interface = rig.network.interface;
  options.host_ip = rig.network.host_ip;
  options.send_utc = rig.network.send_utc;
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.is_livox()) continue;
    if (sensor.lidar->broadcast_code.empty() && !sensor.lidar->ip)
      return input_error("has neither a broadcast_code nor an ip", "sensor '" + sensor.name + "' of the rig",
                         "add one of them: a live LiDAR is known by it");
    options.devices.push_back({sensor.lidar->broadcast_code, sensor.lidar->ip, settings_of(*sensor.lidar)});
  }
  if (options.devices.empty())
    return input_error("has no Livox LiDAR", "rig '" + rig.name + "'",
                       "add one: other LiDARs, and cameras without one, are not recorded live");
  return options;
}

Expected<bool> LiveDatagrams::next(Datagram& datagram) {
  while (true) {
    if (stop_.stop_requested() && driver_.is_running()) driver_.stop();
    if (driver_.next(datagram, wait_ns)) break;
    if (!driver_.is_running()) return false;
  }
  if (recorder_ != nullptr) {
    if (const auto written = recorder_->write(datagram); !written) return written.error();
  }
  return true;
}

FileNotes LiveDatagrams::notes() const {
  FileNotes notes;
  notes.findings = driver_.notes();
  for (const livox::InterfaceReport& report : driver_.interfaces()) {
    const livox::ReceiverCounters& counters = report.counters;
    if (counters.dropped_by_kernel > 0)
      notes.findings.push_back(report.interface.name + ": " + std::to_string(counters.dropped_by_kernel) +
                               " packets were lost because the socket's buffer of " +
                               std::to_string(report.receive_bytes / 1024) + " KiB was full");
    if (counters.dropped_by_queue > 0)
      notes.findings.push_back(report.interface.name + ": " + std::to_string(counters.dropped_by_queue) +
                               " packets were lost because this program or its disk was too slow");
  }
  return notes;
}

}  // namespace rigcal
