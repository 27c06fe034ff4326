#include "apps/recording/rig_lidars.h"

#include <algorithm>

namespace rigcal {

std::vector<int> lidar_sensors(const Rig& rig) {
  std::vector<int> out;
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    if (rig.sensors[k].is_lidar()) out.push_back(static_cast<int>(k));
  }
  const auto name = [&](int sensor) -> const std::string& {
    return rig.sensors[static_cast<std::size_t>(sensor)].name;
  };
  std::sort(out.begin(), out.end(), [&](int a, int b) { return name(a) < name(b); });
  return out;
}

std::vector<std::optional<SE3>> lidar_guesses(const Rig& rig) {
  std::vector<std::optional<SE3>> out;
  for (const int sensor : lidar_sensors(rig)) {
    out.push_back(sensor == rig.base ? SE3{} : rig.sensors[static_cast<std::size_t>(sensor)].initial_T_base_sensor);
  }
  return out;
}

}  // namespace rigcal
