#include "simdata/rig/light_rig.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "simdata/lidar/shot_meter.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/ray_caster.h"

namespace rigcal::sim {
namespace {

enum Stream : std::uint64_t { gyro_stream = 300, patch_stream = 1U << 20U };

// Shots between two placings of the people.
constexpr std::int64_t shots_per_look = 256;

void render_patch(const RayCaster& caster, const std::vector<Material>& materials, const SimulatedRig& simulated,
                  const SimulatedLidar& lidar, const PatchTime& time, const LightRigOptions& options, Patch& patch) {
  const double rate = lidar.scanner.shots_per_s();
  const auto first = static_cast<std::int64_t>(std::ceil(time.start_s * rate));
  const auto fired = static_cast<std::int64_t>(std::floor(time.length_s * rate));
  const std::int64_t shots = std::min<std::int64_t>(options.shots_per_patch, fired);
  const bool moves = simulated.motion.moves_at_rest();
  SE3 T_scene_sensor = simulated.motion.T_scene_base_settled(time.middle_s()) * lidar.T_base_sensor;
  const ShotMeter meter(caster, materials, options.with_noise ? lidar.noise : LidarNoise::none());
  Random random(options.seed,
                patch_stream + static_cast<std::uint64_t>(patch.stop) * 64U + static_cast<std::uint64_t>(lidar.sensor));
  RayCaster::People people;
  patch.points.reserve(static_cast<std::size_t>(shots));
  for (std::int64_t i = 0; i < shots; ++i) {
    // A random shot out of each share of the dwell: an even stride would beat with the laser lines.
    const double place = (static_cast<double>(i) + (shots < fired ? random.uniform() : 0.0)) *
                         static_cast<double>(fired) / static_cast<double>(shots);
    const std::int64_t shot = first + static_cast<std::int64_t>(place);
    if (i % shots_per_look == 0) people = caster.people_at(static_cast<double>(shot) / rate);
    if (moves)
      T_scene_sensor = simulated.motion.T_scene_base_unswung(static_cast<double>(shot) / rate) * lidar.T_base_sensor;
    SE3 T_scene_beam = T_scene_sensor;
    if (lidar.wobble.amplitude_rad != 0.0)
      T_scene_beam.R = T_scene_sensor.R * lidar.wobble.at(static_cast<double>(shot) / rate);
    const Shot measured = meter.measure(T_scene_beam, lidar.scanner.direction(shot), people, random);
    if (measured.count == 0) continue;
    patch.points.push_back(to_point(measured.direction, measured.single(false)));
  }
}

}  // namespace

std::vector<PatchTime> patch_times(const TurntableMotion& motion) {
  std::vector<PatchTime> times;
  for (const Rest& rest : motion.rests()) {
    const double stop_start_s = motion.stop_start_s(rest.stop);
    const double dwell_s = motion.dwell_s(rest.stop);
    const bool is_whole = rest.start_s == stop_start_s && rest.end_s >= stop_start_s + dwell_s;
    const double length_s = is_whole ? dwell_s : std::min(rest.end_s, stop_start_s + dwell_s) - rest.start_s;
    if (length_s > TurntableMotion::bump_s) times.push_back({rest.start_s, length_s});
  }
  return times;
}

Expected<LightRig> make_light_rig(const Scene& scene, const LightRigOptions& options, const Rig& rig) {
  auto simulated = make_simulated_rig(rig, scene.T_scene_table, options.turntable, options.mount_error, options.seed,
                                      options.unit_errors);
  if (!simulated) return simulated.error();
  const RayCaster caster(scene);

  LightRig light;
  light.rig = rig;
  light.T_base_sensor = simulated->T_base_sensor;
  light.axis = simulated->motion.axis_in_base();
  light.axis_point = simulated->motion.axis_point_in_base();
  Random gyro(options.seed, gyro_stream);
  SE3 T_G_scene;
  const std::vector<PatchTime> times = patch_times(simulated->motion);
  for (int k = 0; k < static_cast<int>(times.size()); ++k) {
    const SE3 T_scene_base = simulated->motion.T_scene_base_settled(times[static_cast<std::size_t>(k)].middle_s());
    if (k == 0) {
      light.T_scene_G = T_scene_base;
      T_G_scene = T_scene_base.inverse();
    }
    light.T_G_base.push_back(T_G_scene * T_scene_base);
    for (const SimulatedLidar& lidar : simulated->lidars) light.patches.push_back({lidar.sensor, k, {}});
    if (k == 0) continue;
    const Vector3d error = random_normal3(gyro);
    const Matrix3d step = light.T_G_base[static_cast<std::size_t>(k) - 1].R.transpose() * light.T_G_base.back().R;
    light.step_rotations.push_back(log_so3(step) + to_rad(options.step_rotation_sigma_deg) * error);
  }
  light.lidars = simulated->lidars;
  const std::size_t lidars = simulated->lidars.size();
  parallel_for(light.patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i)
      render_patch(caster, scene.materials, *simulated, simulated->lidars[i % lidars], times[i / lidars], options,
                   light.patches[i]);
  });
  return light;
}

}  // namespace rigcal::sim
