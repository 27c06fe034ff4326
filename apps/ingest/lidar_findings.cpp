#include "apps/ingest/lidar_findings.h"

#include <algorithm>
#include <cstdio>
#include <utility>

#include "core/quality/recording_faults.h"
#include "drivers/livox_codec/status.h"

namespace rigcal {
namespace {

const Sensor& sensor_of(const Rig& rig, const DeviceIngest& device) {
  return rig.sensors[static_cast<std::size_t>(device.sensor)];
}

/// "avia (192.168.1.179)" or "192.168.1.99 (broadcast code 3JED...)".
std::string name_of(const Rig& rig, const DeviceIngest& device) {
  if (device.sensor >= 0) return sensor_of(rig, device).name + " (" + to_string(device.ip) + ")";
  if (device.broadcast_code.empty()) return to_string(device.ip);
  return to_string(device.ip) + " (broadcast code " + device.broadcast_code + ")";
}

void warn_of_identity(const Rig& rig, const DeviceIngest& device, std::vector<std::string>& warnings) {
  const std::string ip = to_string(device.ip);
  const int by_ip = sensor_by_ip(rig, device.ip);
  if (by_ip >= 0 && by_ip != device.sensor && !device.broadcast_code.empty()) {
    const std::string told = device.sensor >= 0 ? "it is used as " + sensor_of(rig, device).name
                                                : "no sensor of the rig file has this code, and it is not used";
    warnings.push_back("the device at " + ip + " says that it is " + device.broadcast_code +
                       ", but the rig file has this address for " + rig.sensors[static_cast<std::size_t>(by_ip)].name +
                       ": " + told);
  } else if (device.sensor < 0 && device.packets > 0) {
    const bool hub = device.type == livox::DeviceType::hub;
    // Where a dump is only looked at there is no rig file that they could belong to.
    if (!hub && rig.sensors.empty()) return;
    warnings.push_back("the " + std::to_string(device.packets) + " packets from " + name_of(rig, device) +
                       (hub ? " is a Hub, whose packets are not read:" : " belong to no sensor of the rig file:") +
                       " they are not used");
  }
  if (device.sensor < 0 || !device.type) return;
  const Sensor& sensor = sensor_of(rig, device);
  const LidarModel model = sensor.lidar->model;
  if (model != LidarModel::other && model != livox::lidar_model(*device.type)) {
    warnings.push_back(sensor.name + " has another type in the rig file than the device at " + ip +
                       " says it is: " + livox::model_name(*device.type));
  }
}

void warn_of_device(const Rig& rig, const DeviceIngest& device, std::vector<std::string>& warnings) {
  const std::string name = name_of(rig, device);
  if (device.malformed > 0) {
    warnings.push_back(name + ": " + std::to_string(device.malformed) + " datagrams are damaged and were left out");
  }
  const livox::Status status = livox::decode_status(device.worst_status);
  if (status.system != livox::Level::normal) {
    char word[16];
    std::snprintf(word, sizeof word, "0x%08X", device.worst_status);
    warnings.push_back(name + ": the sensor reports " +
                       (status.system == livox::Level::warning ? "a warning" : "an error") + " (status " + word + ")");
  }
}

std::string seen_devices(const Rig& rig, const IngestSummary& summary) {
  constexpr std::size_t most_named = 12;
  std::string text;
  std::size_t named = 0;
  for (const DeviceIngest& device : summary.devices) {
    if (device.packets == 0) continue;
    if (++named > most_named) return text + ", ...";
    text += (text.empty() ? "" : ", ") + name_of(rig, device);
  }
  return text.empty() ? "none" : text;
}

std::string expected_at(const LidarSettings& lidar) {
  std::string text;
  if (lidar.ip) text = to_string(*lidar.ip);
  if (!lidar.broadcast_code.empty()) text += (text.empty() ? "" : ", ") + lidar.broadcast_code;
  return text.empty() ? "no ip and no broadcast_code in the rig file" : text;
}

/// One for each sensor of the rig.
std::vector<char> with_points(const Rig& rig, const IngestSummary& summary) {
  std::vector<char> out(rig.sensors.size(), 0);
  for (const DeviceIngest& device : summary.devices) {
    if (device.sensor >= 0 && device.shots > 0) out[static_cast<std::size_t>(device.sensor)] = 1;
  }
  return out;
}

/// What is wrong where LiDARs of the rig gave no points, "no points of mid100_left (192.168.1.21); seen: ..."; empty
/// where all did.
std::string missing_words(const Rig& rig, const IngestSummary& summary, const std::vector<char>& has_points) {
  std::string text;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    if (!rig.sensors[i].is_lidar() || has_points[i]) continue;
    text += (text.empty() ? "" : ", ") + rig.sensors[i].name + " (" + expected_at(*rig.sensors[i].lidar) + ")";
  }
  return text.empty() ? text : "no points of " + text + "; seen: " + seen_devices(rig, summary);
}

/// Whether a rig can be calibrated by the sensors that gave points: the base, and another LiDAR or a camera.
bool is_enough(const Rig& rig, const std::vector<char>& has_points) {
  if (!has_points[static_cast<std::size_t>(rig.base)]) return false;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    if (static_cast<int>(i) != rig.base && (has_points[i] || !rig.sensors[i].is_lidar())) return true;
  }
  return false;
}

constexpr const char* mend_of_missing = "correct ip or broadcast_code in the rig file, or take the sensor out of it";

}  // namespace

std::vector<std::string> ingest_warnings(const Rig& rig, const IngestSummary& summary) {
  std::vector<std::string> warnings;
  for (const DeviceIngest& device : summary.devices) {
    warn_of_identity(rig, device, warnings);
    if (device.sensor < 0) continue;
    warn_of_device(rig, device, warnings);
    const DeviceIngest* other = summary.of_sensor(device.sensor);
    if (other != &device && device.packets > 0) {
      warnings.push_back("both " + to_string(other->ip) + " and " + to_string(device.ip) + " say that they are " +
                         sensor_of(rig, device).name + ": the points of both are used");
    }
  }
  const std::vector<char> has_points = with_points(rig, summary);
  if (const std::string missing = missing_words(rig, summary, has_points);
      !missing.empty() && is_enough(rig, has_points)) {
    warnings.push_back("the recording has " + missing + "; " + mend_of_missing);
  }
  for (const RecordingFault& fault : recording_faults(packet_counters(rig, summary), clock_reports(rig, summary))) {
    warnings.push_back(to_string(fault));
  }
  return warnings;
}

PacketCounters packet_counters(const Rig& rig, const IngestSummary& summary) {
  PacketCounters counters;
  for (const DeviceIngest& device : summary.devices) {
    if (device.sensor < 0 || summary.of_sensor(device.sensor) != &device) continue;
    auto& of_sensor = counters[sensor_of(rig, device).name];
    for (const auto& [stream, name] :
         {std::pair{&device.point_stream, std::string("point_")}, {&device.imu_stream, "imu_"}}) {
      if (stream->received + stream->damaged == 0) continue;
      of_sensor[name + "expected"] = stream->expected();
      of_sensor[name + "received"] = stream->received;
      of_sensor[name + "lost"] = stream->lost;
      of_sensor[name + "duplicated"] = stream->duplicated;
      of_sensor[name + "out_of_order"] = stream->out_of_order;
      of_sensor[name + "damaged"] = stream->damaged;
      of_sensor[name + "gaps"] = stream->gaps;
      of_sensor[name + "longest_gap_ms"] = static_cast<std::uint64_t>(stream->longest_gap.length_ns / 1'000'000);
    }
  }
  return counters;
}

std::vector<ClockReport> clock_reports(const Rig& rig, const IngestSummary& summary) {
  std::vector<ClockReport> reports;
  const auto add = [&](int sensor, const ClockFigures& clock) {
    if (sensor < 0 || clock.packets == 0) return;
    reports.push_back({rig.sensors[static_cast<std::size_t>(sensor)].name, clock.drift_ppm, 1e-3 * clock.jitter_ns,
                       1e-3 * clock.max_delay_ns, clock.jumps, clock.strays});
  };
  for (const DeviceIngest& device : summary.devices) add(device.sensor, device.clock);
  for (const TopicIngest& topic : summary.topics) {
    if (topic.points > 0) add(topic.sensor, topic.clock);
  }
  return reports;
}

std::optional<Error> ingest_error(const Rig& rig, const IngestSummary& summary, bool learned_too_late) {
  const bool any = std::any_of(summary.devices.begin(), summary.devices.end(),
                               [](const DeviceIngest& device) { return device.packets > 0; });
  if (!any) {
    return input_error(
        "the recording holds no Livox packet among " + std::to_string(summary.datagrams) + " UDP datagrams", {},
        "record the ports that the sensors send to");
  }
  if (learned_too_late) {
    return input_error("a sensor told its broadcast code after packets from its address had been used otherwise", {},
                       "correct the ip addresses in the rig file");
  }
  const std::vector<char> has_points = with_points(rig, summary);
  const std::string missing = missing_words(rig, summary, has_points);
  if (missing.empty() || is_enough(rig, has_points)) return std::nullopt;
  return input_error("the recording has " + missing, {}, mend_of_missing);
}

}  // namespace rigcal
