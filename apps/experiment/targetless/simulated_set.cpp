#include "apps/experiment/targetless/simulated_set.h"

#include <algorithm>

#include "apps/experiment/light_runs.h"
#include "simdata/scene/random_vectors.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t set_odometry_stream = 900;

std::vector<std::optional<SE3>> rough_poses(const sim::LightRig& light, const SetOptions& options) {
  Random random(options.seed, set_odometry_stream);
  std::vector<std::optional<SE3>> out;
  for (const SE3& T : light.T_G_base) {
    const SE3 rough = rough_pose(T, options, random);
    out.emplace_back(out.empty() ? T : rough);
  }
  return out;
}

Vector3d drawn_in_cube(double half, Random& random) {
  Vector3d out;
  for (int k = 0; k < 3; ++k) out[k] = random.uniform(-half, half);
  return out;
}

}  // namespace

SE3 rough_pose(const SE3& T, const SetOptions& options, Random& random) {
  const Vector3d turn = to_rad(options.pose_error_deg) * sim::random_normal3(random);
  const Vector3d shift = options.pose_error_m * sim::random_normal3(random);
  return T * SE3{exp_so3(turn), shift};
}

RigState SimulatedSet::start(const std::vector<SE3>& T_base_sensor) const {
  RigState state;
  for (const auto& T : recording.trajectory) state.T_G_base.push_back(*T);
  state.T_base_sensor = T_base_sensor;
  return state;
}

Expected<SimulatedSet> make_set(const SetOptions& options, const sim::Scene& scene) {
  SimulatedSet out;
  out.scene = options.scene;
  sim::LightRigOptions light;
  light.seed = options.seed;
  light.shots_per_patch = options.points;
  light.turntable.stops = options.stops;
  light.turntable.drive_m = options.drive_m;
  if (options.wander_m > 0.0) sim::let_wander(options.wander_m, options.wander_deg, light.turntable);
  Expected<sim::LightRig> made = sim::make_light_rig(scene, light, options.rig);
  if (!made) return made.error();
  out.light = std::move(*made);
  out.patches = out.light.patches;
  out.recording = light_recording(out.light, false);
  out.recording.trajectory = rough_poses(out.light, options);
  return out;
}

std::vector<SE3> spoiled(const SimulatedSet& set, double rotation_deg, double translation_m, Random& random) {
  std::vector<SE3> out = set.light.T_base_sensor;
  for (std::size_t i = 0; i < out.size(); ++i) {
    if (static_cast<int>(i) == set.light.rig.base) continue;
    const Vector3d turn = drawn_in_cube(to_rad(rotation_deg), random);
    const Vector3d shift = drawn_in_cube(translation_m, random);
    out[i] = SE3{out[i].R * exp_so3(turn), out[i].t + shift};
  }
  return out;
}

RigError error_of(const std::vector<SE3>& T_base_sensor, const SimulatedSet& set) {
  RigError out;
  int count = 0;
  for (std::size_t i = 0; i < T_base_sensor.size(); ++i) {
    if (static_cast<int>(i) == set.light.rig.base) continue;
    const SE3& truth = set.light.T_base_sensor[i];
    const double rad = rotation_distance(T_base_sensor[i].R, truth.R);
    const double m = (T_base_sensor[i].t - truth.t).norm();
    out.rotation_rad += rad;
    out.translation_m += m;
    out.worst_rotation_rad = std::max(out.worst_rotation_rad, rad);
    out.worst_translation_m = std::max(out.worst_translation_m, m);
    ++count;
  }
  out.rotation_rad /= std::max(count, 1);
  out.translation_m /= std::max(count, 1);
  return out;
}

}  // namespace rigcal::targetless
