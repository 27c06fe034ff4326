#include "apps/recording/session_counters.h"

#include "core/records/records.h"

namespace rigcal {

SessionCounters session_counters(const Rig& rig, const IngestSummary& ingest) {
  const auto name = [&rig](int sensor, const std::string& other) {
    return sensor < 0 ? other : rig.sensors[static_cast<std::size_t>(sensor)].name;
  };
  SessionCounters counters;
  for (const DeviceIngest& device : ingest.devices) {
    auto& of_device = counters[name(device.sensor, to_string(device.ip))];
    of_device["packets"] += device.packets;
    of_device["lost"] += device.point_stream.lost + device.imu_stream.lost;
    of_device["duplicates"] += device.point_stream.duplicated + device.imu_stream.duplicated;
    of_device["malformed"] += device.malformed;
    of_device["points"] += device.points;
    of_device["imu_samples"] += device.imu_samples;
  }
  for (const TopicIngest& topic : ingest.topics) {
    if (topic.sensor < 0) continue;
    auto& of_sensor = counters[name(topic.sensor, "")];
    of_sensor["messages"] += topic.messages;
    of_sensor["lost"] += topic.lost;
    of_sensor["malformed"] += topic.malformed;
    of_sensor["points"] += topic.points;
    of_sensor["imu_samples"] += topic.imu_samples;
  }
  return counters;
}

}  // namespace rigcal
