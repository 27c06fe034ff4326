#include "apps/experiment/speed/speed_set.h"

#include <algorithm>
#include <cmath>

#include "apps/experiment/light_runs.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::speed {
namespace {

constexpr double seen_share = 0.95;  // of the shots in a courtyard; the others see the sky

// The usual rig, or its first LiDARs, or it and more units like its last around the base.
Rig rig_with(int lidars) {
  Rig rig = sim::nominal_rig();
  const auto count = static_cast<std::size_t>(lidars);
  while (rig.sensors.size() > count) rig.sensors.pop_back();
  const std::size_t usual = rig.sensors.size();
  while (rig.sensors.size() < count) {
    Sensor more = sim::nominal_rig().sensors.back();
    more.name = "more_" + std::to_string(rig.sensors.size());
    const double yaw = 2.0 * pi * static_cast<double>(rig.sensors.size() - usual + 1) / static_cast<double>(count);
    more.initial_T_base_sensor = SE3{exp_so3({0.0, 0.0, yaw}), {-0.15 * std::cos(yaw), -0.15 * std::sin(yaw), -0.2}};
    rig.sensors.push_back(std::move(more));
  }
  return rig;
}

}  // namespace

std::vector<PatchCells> SpeedSet::cells(bool with_map) const {
  CellOptions options;
  options.keep_thinned = with_map;
  return cells_of_patches(patches, options);
}

Expected<SpeedSet> make_set(const SetOptions& options) {
  const Expected<sim::Scene> scene = sim::load_scene(options.scene);
  if (!scene) return scene.error();
  sim::LightRigOptions light;
  light.seed = options.seed;
  light.turntable.stops = options.stops;
  light.shots_per_patch = std::max(200, static_cast<int>(options.points / options.lidars / options.stops / seen_share));
  const double slowest_shots_hz = facts_of(LidarModel::livox_mid40).shots_per_s;
  light.turntable.dwell_s = std::max(2.0, light.shots_per_patch / slowest_shots_hz + 0.1);
  Expected<sim::LightRig> made = sim::make_light_rig(*scene, light, rig_with(options.lidars));
  if (!made) return made.error();
  SpeedSet out;
  out.patches = std::move(made->patches);
  made->patches.clear();
  out.recording = light_recording(*made, true);
  out.rig = made->rig;
  out.truth = {made->T_G_base, made->T_base_sensor};
  for (const Sensor& sensor : out.rig.sensors) out.guess.push_back(sensor.initial_T_base_sensor);
  out.guess[static_cast<std::size_t>(out.rig.base)] = SE3{};
  for (const Patch& patch : out.patches) out.points += patch.points.size();
  return out;
}

}  // namespace rigcal::speed
