#include "apps/experiment/light_runs.h"

#include "core/base/random.h"
#include "core/voxel/patch_of_points.h"

namespace rigcal {
namespace {

constexpr std::uint64_t stops_stream = 900;

}  // namespace

sim::LightRigOptions sigma_run(std::uint64_t seed, int points, double range_bias_m, double footprint_share) {
  sim::LightRigOptions options;
  options.seed = seed;
  options.shots_per_patch = points;
  options.unit_errors.range_bias_sigma_m = range_bias_m;
  options.unit_errors.footprint_share = footprint_share;
  options.turntable.stops = 12 + static_cast<int>(Random(seed, stops_stream).below(13));
  return options;
}

LidarRecording light_recording(sim::LightRig& light, bool with_gyro) {
  LidarRecording out;
  for (std::size_t i = 0; i < light.rig.sensors.size(); ++i) out.lidar_sensors.push_back(static_cast<int>(i));
  for (std::size_t j = 0; j < light.T_G_base.size(); ++j) {
    out.stops.push_back({static_cast<int>(j), 0, 0});
    if (!with_gyro) continue;
    out.R_previous_this.emplace_back();
    out.gyro_turns.emplace_back();
    if (j == 0) continue;
    out.R_previous_this.back() = exp_so3(light.step_rotations[j - 1]);
    out.gyro_turns.back() = GyroTurn{light.rig.base, *out.R_previous_this.back()};
  }
  out.patches = cells_of_patches(light.patches, CellOptions{});
  for (Patch& patch : light.patches) patch.points = {};
  return out;
}

Expected<CalibrationResult> calibrate_from_guesses(sim::LightRig& light, const RunContext& context) {
  std::vector<std::optional<SE3>> guess;
  for (const Sensor& sensor : light.rig.sensors) guess.push_back(sensor.initial_T_base_sensor);
  guess[static_cast<std::size_t>(light.rig.base)] = SE3{};
  LidarCalibrationOptions options;
  options.with_map = false;
  return calibrate_lidars(light.rig, light_recording(light, true), guess, options, context);
}

}  // namespace rigcal
