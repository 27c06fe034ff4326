#include "simdata/camera/camera_shots.h"

#include <algorithm>

#include "core/base/random.h"
#include "core/base/seconds.h"

namespace rigcal::sim {
namespace {

enum Stream : std::uint64_t { camera_clock_stream = 700 };
constexpr std::uint64_t most_frames = 1'000'000;  // of one camera

/// From the beginning of a pulse.
double delay_of(const Rig& rig, const TriggerSettings& trigger) {
  const double pulse_us = rig.trigger ? rig.trigger->pulse_us : TriggerLineSettings{}.pulse_us;
  return 1e-6 * (trigger.delay_us + (trigger.activation == "falling" ? pulse_us : 0.0));
}

}  // namespace

std::uint64_t SimulatedCamera::noise_of(std::uint64_t frame) const {
  return static_cast<std::uint64_t>(sensor) * most_frames + frame;
}

Expected<std::vector<SimulatedCamera>> simulated_cameras(const Rig& rig, const std::vector<SE3>& T_base_sensor) {
  std::vector<SimulatedCamera> cameras;
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const Sensor& sensor = rig.sensors[i];
    if (sensor.is_lidar() || !sensor.camera->intrinsics) continue;
    const auto chip = ImageSensor::of(sensor);
    if (!chip) return chip.error();
    const auto& trigger = sensor.camera->trigger;
    cameras.push_back({static_cast<int>(i), sensor.name, *chip, T_base_sensor[i],
                       CameraModel(*sensor.camera->intrinsics), trigger.has_value(),
                       trigger ? delay_of(rig, *trigger) : 0.0});
  }
  return cameras;
}

std::vector<ExposurePulse> plan_exposures(const std::vector<SimulatedCamera>& cameras, const TurntableMotion& motion,
                                          int per_stop) {
  double longest_s = 0.0;
  for (const SimulatedCamera& camera : cameras) longest_s = std::max(longest_s, camera.delay_s + camera.exposure_s());
  return plan_exposures(motion.rests(), per_stop, longest_s);
}

ClockTruth camera_clock(std::uint64_t seed, int sensor) {
  Random random(seed, camera_clock_stream + static_cast<std::uint64_t>(sensor));
  const double started_s = random.uniform(20.0, 600.0);
  return {ns_of_seconds(started_s), random.uniform(-50.0, 50.0)};
}

}  // namespace rigcal::sim
