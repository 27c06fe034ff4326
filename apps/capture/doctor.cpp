#include "apps/capture/doctor.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "core/base/version.h"
#include "drivers/livox/protocol/abilities.h"
#include "drivers/livox_codec/status.h"

namespace rigcal {
namespace {

constexpr int ethernet_mtu = 1500;
constexpr double free_running_ppm = 100.0;  // A quartz that drifts more is broken, or the stamps are.
// In less, packets that are late by some tens of microseconds look like a drift.
constexpr std::int64_t least_for_drift_ns = 3'000'000'000;
constexpr double synchronised_ppm = 5.0;  // What is left of the drift within some seconds of delays that jitter.

const char* to_string(CheckLevel level) {
  switch (level) {
    case CheckLevel::good:
      return "good";
    case CheckLevel::warning:
      return "warning";
    case CheckLevel::bad:
      return "bad";
  }
  return "?";
}

std::string one_decimal(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

Check check_address(const std::string& sensor, const livox::Ipv4& ip, const std::vector<net::Interface>& interfaces) {
  std::vector<const net::Interface*> fitting;
  for (const net::Interface& interface : interfaces)
    if (net::is_in_subnet(interface, ip)) fitting.push_back(&interface);
  if (fitting.empty())
    return {CheckLevel::bad, sensor, "no interface of this machine is in the subnet of " + rigcal::to_string(ip),
            "give the one that its cable is in an address there, for example: sudo ip addr add " +
                std::to_string(ip[0]) + "." + std::to_string(ip[1]) + "." + std::to_string(ip[2]) + ".5/24 dev NAME"};
  const net::Interface& interface = *fitting.front();
  const std::string way = interface.name + " (" + rigcal::to_string(interface.ip) + "/" +
                          std::to_string(net::prefix_length(interface.mask)) + ")";
  if (!interface.is_up)
    return {CheckLevel::bad, sensor, way + " is down or has no carrier",
            "plug the cable in, or: sudo ip link set " + interface.name + " up"};
  if (fitting.size() > 1)
    return {CheckLevel::warning, sensor, way + " and " + fitting[1]->name + " are in its subnet",
            "take one of the addresses away, or name the interface in the rig file (lidar: {interface: NAME})"};
  if (interface.mtu > 0 && interface.mtu < ethernet_mtu)
    return {CheckLevel::warning, sensor,
            way + " has an MTU of " + std::to_string(interface.mtu) + ", too little for packets of points",
            "sudo ip link set " + interface.name + " mtu 1500"};
  return {CheckLevel::good, sensor, "is to be reached by " + way, {}};
}

Check check_presence(const std::string& sensor, const livox::DeviceReport& device, bool was_heard) {
  const livox::LinkInfo& link = device.link;
  const livox::LinkCounters& counters = link.counters;
  if (link.firmware == livox::FirmwareVersion{} && !was_heard)
    return {
        CheckLevel::bad, sensor, "was not heard",
        "look at its power and cable; let UDP port 55000 through the firewall; end other programs that may have it"};
  if (link.firmware == livox::FirmwareVersion{} && counters.handshakes > 0)
    return {CheckLevel::bad, sensor, "broadcasts, but does not take this host",
            "end other programs that may have it, and let UDP through the firewall"};
  if (link.firmware == livox::FirmwareVersion{})
    return {CheckLevel::bad, sensor, "broadcasts, but has an address in another subnet: " + rigcal::to_string(link.ip),
            "give this machine an address there"};
  const std::string who = livox::model_name(link.broadcast.type) + ", firmware " + livox::firmware_text(link.firmware) +
                          ", at " + rigcal::to_string(link.ip) + ", " + livox::to_string(link.work_state);
  if (counters.losses > 0)
    return {CheckLevel::warning, sensor,
            who + "; the connection was lost " + std::to_string(counters.losses) + " times",
            "look at its cable, switch and power"};
  if (device.packets == 0)
    return {CheckLevel::bad, sensor, who + "; sends no points",
            "wait until it has spun up; let UDP through the firewall"};
  return {CheckLevel::good, sensor, who, {}};
}

void add_status(const std::string& sensor, std::uint32_t status, std::vector<Check>& checks) {
  const bool is_error = livox::decode_status(status).system == livox::Level::error;
  for (const std::string& word : status_words(status))
    checks.push_back(
        {is_error ? CheckLevel::bad : CheckLevel::warning, sensor, "says: " + word, "see the vendor's manual for it"});
}

// By how its stamps drift, whatever its flag says.
void add_clock(const std::string& sensor, const DeviceIngest& device, std::uint32_t status,
               std::vector<Check>& checks) {
  if (device.last_ns - device.first_ns < least_for_drift_ns) {
    if (device.clock.packets > 0)
      checks.push_back({CheckLevel::good, sensor, "how its clock runs is not known yet: look for 5 s or longer", {}});
    return;
  }
  const double drift = device.clock.drift_ppm;
  const std::string runs = "its clock runs " + one_decimal(std::abs(drift)) + " ppm " + (drift < 0.0 ? "slow" : "fast");
  const livox::Status decoded = livox::decode_status(status);
  const bool claims_sync = decoded.time_sync == livox::TimeSync::ptp || decoded.time_sync == livox::TimeSync::gps ||
                           decoded.time_sync == livox::TimeSync::pps;
  const std::string sync = livox::sync_text(decoded);
  if (std::abs(drift) > free_running_ppm) {
    checks.push_back({CheckLevel::warning, sensor, runs, "restart the device; is the load of this machine too high?"});
  } else if (claims_sync && std::abs(drift) > synchronised_ppm) {
    checks.push_back({CheckLevel::warning, sensor, runs + ", although it says that it is " + sync,
                      "synchronise this machine's clock with the same master"});
  } else {
    checks.push_back(
        {CheckLevel::good, sensor, runs + "; " + sync + (claims_sync ? "" : ", which is accounted for"), {}});
  }
}

void add_losses(const std::string& sensor, const DeviceIngest& device, std::vector<Check>& checks) {
  const std::uint64_t lost = device.point_stream.lost + device.imu_stream.lost;
  if (lost > 0)
    checks.push_back({CheckLevel::warning, sensor,
                      std::to_string(lost) + " of " +
                          std::to_string(device.point_stream.expected() + device.imu_stream.expected()) +
                          " packets were lost",
                      "raise the receive buffer, and look at cable and switch"});
}

}  // namespace

std::vector<std::string> status_words(std::uint32_t status) {
  const livox::Status decoded = livox::decode_status(status);
  std::vector<std::string> words;
  const auto level = [&words](livox::Level value, const char* warning, const char* error) {
    if (value == livox::Level::warning) words.emplace_back(warning);
    if (value == livox::Level::error) words.emplace_back(error);
  };
  level(decoded.temperature, "temperature high or low", "temperature extreme");
  level(decoded.voltage, "voltage high", "voltage extremely high");
  level(decoded.motor, "motor warning", "motor error");
  if (decoded.dirty != 0) words.emplace_back("window dirty or blocked");
  if (decoded.firmware_abnormal) words.emplace_back("firmware abnormal, must be updated");
  if (decoded.near_end_of_life) words.emplace_back("near the end of its life");
  if (decoded.fan_warning) words.emplace_back("fan warning");
  if (decoded.time_sync == livox::TimeSync::abnormal) words.emplace_back("time synchronisation has failed");
  return words;
}

std::vector<Check> check_network(const Rig& rig, const std::vector<net::Interface>& interfaces) {
  std::vector<Check> checks;
  for (const Sensor& sensor : rig.sensors)
    if (sensor.is_lidar() && sensor.lidar->ip)
      checks.push_back(check_address(sensor.name, *sensor.lidar->ip, interfaces));
  return checks;
}

Check check_receive_buffer(std::optional<std::size_t> largest, std::size_t needed) {
  if (largest && *largest < needed)
    return {CheckLevel::warning, "receive buffer",
            "the system allows " + std::to_string(*largest / 1024) + " KiB, " + std::to_string(needed / 1024) +
                " are needed so that packets do not get lost when the machine is busy",
            "sudo sysctl -w net.core.rmem_max=" + std::to_string(needed) + " (in /etc/sysctl.d to keep it)"};
  return {CheckLevel::good,
          "receive buffer",
          largest ? "the system allows " + std::to_string(*largest / 1024) + " KiB" : "the system does not say",
          {}};
}

Check check_discovery_port(const std::vector<net::PortHolder>& holders) {
  if (holders.empty()) return {CheckLevel::good, "discovery", "UDP port 55000 is free", {}};
  return {CheckLevel::warning, "discovery",
          "UDP port 55000 is taken by " + net::holders_text(holders) + ", which may take the LiDARs, too",
          "end it while you record"};
}

std::string rivals_text(std::vector<net::PortHolder> holders, int own, std::uint16_t port) {
  std::erase_if(holders, [&](const net::PortHolder& holder) { return holder.pid == own; });
  if (holders.empty()) return {};
  return "UDP port " + std::to_string(port) + " is also taken by " + net::holders_text(holders) +
         ", which may have taken them: end it, they are taken then";
}

std::vector<Check> check_firewalls(const std::vector<net::Firewall>& firewalls, bool all_is_heard) {
  std::vector<Check> checks;
  for (const net::Firewall& firewall : firewalls) {
    if (all_is_heard) {
      checks.push_back({CheckLevel::good, "firewall", firewall.name + " is on, and lets the LiDARs through", {}});
    } else {
      checks.push_back({CheckLevel::warning, "firewall",
                        firewall.name + " is on and may keep the LiDARs' packets out: they come to UDP port 55000 and "
                                        "to ports that this program chooses anew each time",
                        firewall.mend});
    }
  }
  return checks;
}

std::vector<Check> check_lidars(const Rig& rig, const LidarFindings& findings) {
  std::vector<Check> checks;
  for (std::size_t i = 0; i < findings.devices.size(); ++i) {
    const std::string& name = findings.sensors[i];
    const livox::LinkInfo& link = findings.devices[i].link;
    const bool was_heard = std::any_of(findings.sightings.begin(), findings.sightings.end(),
                                       [i](const livox::Sighting& sighting) { return sighting.device == i; });
    checks.push_back(check_presence(name, findings.devices[i], was_heard));
    const int sensor = rig.find(name);
    const auto& expected = rig.sensors[static_cast<std::size_t>(sensor)].lidar->ip;
    if (was_heard && expected && *expected != link.ip)
      checks.push_back({CheckLevel::warning, name,
                        "has the address " + rigcal::to_string(link.ip) + ", not " + rigcal::to_string(*expected),
                        "write the new one into the rig file"});
    for (const livox::MissingSetting& missing : link.missing_settings)
      checks.push_back({CheckLevel::warning, name, livox::missing_text(missing.setting, missing.outcome),
                        livox::mend_of_missing(missing.outcome)});
    add_status(name, link.status, checks);
    if (const DeviceIngest* device = findings.ingest.of_sensor(sensor)) {
      add_clock(name, *device, link.status, checks);
      add_losses(name, *device, checks);
    }
  }
  for (const livox::Sighting& sighting : findings.sightings) {
    if (sighting.device != livox::kNoDevice) continue;
    const std::string who = livox::model_name(sighting.broadcast.type) + " " + sighting.broadcast.broadcast_code +
                            " at " + rigcal::to_string(sighting.ip) + " is not in the rig file";
    const bool has_address_of_another =
        std::any_of(rig.sensors.begin(), rig.sensors.end(),
                    [&sighting](const Sensor& sensor) { return sensor.is_lidar() && sensor.lidar->ip == sighting.ip; });
    checks.push_back({has_address_of_another ? CheckLevel::bad : CheckLevel::good, "other devices", who,
                      has_address_of_another ? "a sensor of the rig has the same address: correct the rig file's "
                                               "broadcast_code, or give the device another address"
                                             : ""});
  }
  return checks;
}

std::string checks_text(const std::vector<Check>& checks) {
  std::string text;
  for (const Check& check : checks) {
    text += std::string(to_string(check.level)) + ": " + check.about + ": " + check.what;
    if (check.level != CheckLevel::good && !check.mend.empty()) text += "; " + check.mend;
    text += '\n';
  }
  return text;
}

std::string checks_json(const std::vector<Check>& checks) {
  nlohmann::ordered_json json{
      {"rigcal", format_version}, {"command", "doctor"}, {"level", to_string(worst_of(checks))}};
  json["checks"] = nlohmann::ordered_json::array();
  for (const Check& check : checks)
    json["checks"].push_back(
        {{"level", to_string(check.level)}, {"about", check.about}, {"what", check.what}, {"mend", check.mend}});
  return json_text(json);
}

CheckLevel worst_of(const std::vector<Check>& checks) {
  CheckLevel worst = CheckLevel::good;
  for (const Check& check : checks) worst = std::max(worst, check.level);
  return worst;
}

}  // namespace rigcal
