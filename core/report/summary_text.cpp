#include "core/report/summary_text.h"

#include <algorithm>

#include "core/base/text.h"
#include "core/quality/lidar_quality.h"

namespace rigcal {

std::string summary_sentence(const CalibrationResult& result) {
  const auto all = result.sensors.size();
  const auto good = static_cast<std::size_t>(std::count_if(
      result.sensors.begin(), result.sensors.end(), [](const SensorResult& s) { return s.status == Status::good; }));
  if (good == all) return all == 1 ? "The one sensor is good." : "All " + std::to_string(all) + " sensors are good.";
  std::string others;
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.status == Status::good) continue;
    others += (others.empty() ? "" : ", ") + sensor.name + (sensor.status == Status::weak ? " is weak" : " failed");
  }
  const char* verb = good == 1 ? " is good: " : " are good: ";
  return std::to_string(good) + " of " + std::to_string(all) + " sensors" + verb + others + ".";
}

std::string bounds_text(const CalibrationResult& result, const SensorResult& sensor) {
  if (!sensor.T_base_sensor) return "no transform";
  if (sensor.name == result.base) return "the base: all others are told relative to it";
  return "known to " + fixed_text(1e3 * translation_bound(sensor.covariance), 1) + " mm and " +
         fixed_text(to_deg(rotation_bound(sensor.covariance)), 3) + " degrees (95 %)";
}

std::string worked_point_text(const std::string& sensor, bool is_camera, const std::string& base,
                              const SE3& T_base_sensor) {
  const Vector3d p = T_base_sensor * Vector3d::UnitX();
  return std::string("1 m ") + (is_camera ? "to the right of " : "ahead of ") + sensor + ", [1, 0, 0], is [" +
         fixed_text(p.x(), 3) + ", " + fixed_text(p.y(), 3) + ", " + fixed_text(p.z(), 3) + "] in " + base;
}

}  // namespace rigcal
