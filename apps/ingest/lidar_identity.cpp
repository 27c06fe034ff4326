#include "apps/ingest/lidar_identity.h"

#include <algorithm>

namespace rigcal {
namespace {

template <class Match>
int find_lidar(const Rig& rig, const Match& match) {
  const auto found = std::find_if(rig.sensors.begin(), rig.sensors.end(),
                                  [&match](const Sensor& sensor) { return sensor.is_lidar() && match(*sensor.lidar); });
  return found == rig.sensors.end() ? -1 : static_cast<int>(found - rig.sensors.begin());
}

}  // namespace

int sensor_by_ip(const Rig& rig, const IpAddress& ip) {
  return find_lidar(rig, [&ip](const LidarSettings& lidar) { return lidar.ip == ip; });
}

int sensor_at(const Rig& rig, const BroadcastCodes& codes, const IpAddress& ip) {
  const int by_ip = sensor_by_ip(rig, ip);
  const std::string expected = by_ip < 0 ? "" : rig.sensors[static_cast<std::size_t>(by_ip)].lidar->broadcast_code;
  const auto told = codes.find(ip);
  if (told == codes.end()) {
    const bool elsewhere = !expected.empty() && std::any_of(codes.begin(), codes.end(), [&expected](const auto& entry) {
      return entry.second == expected;
    });
    return elsewhere ? -1 : by_ip;
  }
  const int by_code =
      find_lidar(rig, [&told](const LidarSettings& lidar) { return lidar.broadcast_code == told->second; });
  if (by_code >= 0) return by_code;
  return expected.empty() ? by_ip : -1;
}

}  // namespace rigcal
