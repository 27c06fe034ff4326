#include "simdata/packets/sim_device.h"

#include <algorithm>

#include "core/base/random.h"
#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

enum Stream : std::uint64_t { clock_stream = 400 };

// What the vendor's software takes for its first device.
constexpr std::uint16_t first_data_port = 56001;

Error device_error(const Sensor& sensor, std::string what, std::string mend) {
  return input_error(std::move(what), "sensor '" + sensor.name + "' of the rig", std::move(mend));
}

Expected<livox::DataType> data_type_of(const Sensor& sensor) {
  const LidarSettings& lidar = *sensor.lidar;
  const bool spherical = lidar.coordinates == CoordinateSystem::spherical;
  const ReturnMode mode = lidar.return_mode.value_or(ReturnMode::strongest);
  const bool single = mode == ReturnMode::first || mode == ReturnMode::strongest;
  const LidarFacts& model = facts_of(lidar.model);
  if (model.echoes == 1) {
    if (!single)
      return device_error(sensor, std::string("a ") + model.name + " has no such return mode", "take return_mode away");
    return spherical ? livox::DataType::spherical : livox::DataType::cartesian;
  }
  if (mode == ReturnMode::triple && model.echoes < 3)
    return device_error(sensor, std::string("a ") + model.name + " has no return mode triple",
                        "write return_mode: dual, or take it away");
  if (mode == ReturnMode::dual) return spherical ? livox::DataType::dual_spherical : livox::DataType::dual_cartesian;
  if (mode == ReturnMode::triple)
    return spherical ? livox::DataType::triple_spherical : livox::DataType::triple_cartesian;
  return spherical ? livox::DataType::spherical_tagged : livox::DataType::cartesian_tagged;
}

std::string code_of(const LidarSettings& lidar, livox::DeviceType type, int sensor) {
  return lidar.broadcast_code.empty() ? made_up_code(type, sensor) : lidar.broadcast_code;
}

}  // namespace

std::string made_up_code(livox::DeviceType type, int number) {
  std::string digits = std::to_string(number);
  digits.insert(0, 4 - std::min<std::size_t>(4, digits.size()), '0');
  return livox::facts_of(type).livox.code_letters + ("SIM000" + digits) + "1";
}

std::int64_t DeviceClock::stamp_ns(double true_seconds) const {
  return stamp_at_zero_ns + ns_of_seconds(true_seconds * (1.0 + drift));
}

void set_data_type(SimDevice& device, livox::DataType type) {
  device.points = type;
  device.packet_interval_ns =
      ns_of_seconds(livox::record_layout(type).slots / livox::facts_of(device.broadcast.type).shots_per_s);
}

Endpoint broadcast_address(const livox::Ipv4& host, std::uint16_t port) {
  return {host[0] == 127 ? host : livox::Ipv4{255, 255, 255, 255}, port};
}

Expected<std::array<std::uint8_t, 4>> host_address(const Rig& rig) {
  if (rig.network.host_ip != "auto") {
    const auto ip = parse_ip(rig.network.host_ip);
    if (!ip)
      return input_error("'" + rig.network.host_ip + "' is no address", "lidar.host_ip of the rig",
                         "write it as 192.168.1.5, or auto");
    return *ip;
  }
  for (const Sensor& sensor : rig.sensors) {
    if (!sensor.is_lidar() || !sensor.lidar->ip) continue;
    std::array<std::uint8_t, 4> ip = *sensor.lidar->ip;
    if (ip[0] == 127) return std::array<std::uint8_t, 4>{127, 0, 0, 1};
    ip[3] = 5;
    return ip;
  }
  return std::array<std::uint8_t, 4>{192, 168, 1, 5};
}

Expected<std::vector<SimDevice>> make_devices(const Rig& rig, std::uint64_t seed, double clock_drift_ppm) {
  const auto host = host_address(rig);
  if (!host) return host.error();
  std::vector<SimDevice> devices;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const Sensor& sensor = rig.sensors[i];
    if (!sensor.is_lidar()) continue;
    const auto model = livox::device_type(sensor.lidar->model);
    if (!model)
      return device_error(sensor, "how a LiDAR of the type 'lidar' scans is not known",
                          "simulate LiDARs of Livox: livox_avia, livox_mid40 and so on");
    const auto points = data_type_of(sensor);
    if (!points) return points.error();
    if (!sensor.lidar->ip) return device_error(sensor, "has no ip", "packets need addresses: add ip to the sensor");
    for (const SimDevice& other : devices)
      if (other.point_source.ip == *sensor.lidar->ip)
        return device_error(sensor, "has the ip of another sensor", "give every sensor its own");
    SimDevice device;
    device.sensor = static_cast<int>(i);
    device.broadcast = {code_of(*sensor.lidar, *model, device.sensor), *model, livox::kDevicePort};
    device.nearest_only = sensor.lidar->return_mode == ReturnMode::first;
    // The last digit of a MID-100's code says which of its three units it is.
    const char digit = device.broadcast.broadcast_code.back();
    if (*model == livox::DeviceType::mid40 && digit >= '1' && digit <= '3')
      device.lidar_id = static_cast<std::uint8_t>(digit - '0');
    device.has_imu = livox::facts_of(*model).has_imu && sensor.lidar->imu.value_or(true);
    device.point_source = {*sensor.lidar->ip, livox::kPointSourcePort};
    device.imu_source = {*sensor.lidar->ip, livox::kImuSourcePort};
    device.data_sink = {*host, static_cast<std::uint16_t>(first_data_port + devices.size())};
    Random random(seed, clock_stream + i);
    device.clock.stamp_at_zero_ns = ns_of_seconds(random.uniform(20.0, 600.0));
    device.clock.drift = random.uniform(-1e-6 * clock_drift_ppm, 1e-6 * clock_drift_ppm);
    set_data_type(device, *points);
    devices.push_back(device);
  }
  return devices;
}

}  // namespace rigcal::sim
