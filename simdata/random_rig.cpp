#include "simdata/random_rig.h"

#include <Eigen/Eigenvalues>

#include "simdata/random_vectors.h"
#include "simdata/ray_caster.h"

namespace rigcal::sim {
namespace {

constexpr std::uint64_t thrown_stream = 700;

Matrix3d random_rotation(Random& random) {
  Eigen::Vector4d xyzw;
  for (int k = 0; k < 4; ++k) xyzw[k] = random.normal();
  return rotation_from_xyzw(xyzw);
}

SE3 draw_mounting(Random& random, double reach_m) {
  const Matrix3d R = random_rotation(random);
  const double distance = reach_m * random.uniform();
  return {R, distance * random_direction(random)};
}

bool sees_all_directions(const RayCaster& caster, const TurntableMotion& motion, const SimulatedLidar& lidar,
                         const SE3& T_base_sensor) {
  constexpr int shots = 60;  // at each stop, all over the scan
  constexpr std::int64_t stride = 991;
  const RayCaster::People nobody;
  Matrix3d normals = Matrix3d::Zero();
  int hits = 0;
  for (int k = 0; k < motion.stop_count(); ++k) {
    const SE3 T = motion.T_scene_base_at_stop(k) * T_base_sensor;
    for (int i = 0; i < shots; ++i) {
      const auto hit = caster.cast(T.t, T.R * lidar.scanner.direction(i * stride), nobody, 60.0);
      if (!hit) continue;
      ++hits;
      normals += hit->normal * hit->normal.transpose();
    }
  }
  if (hits < 0.4 * shots * motion.stop_count()) return false;
  return Eigen::SelfAdjointEigenSolver<Matrix3d>(normals).eigenvalues()[0] >= 0.04 * hits;
}

}  // namespace

Expected<LightRig> make_random_rig(const Scene& scene, const LightRigOptions& options, const RandomMounting& mounting) {
  // What is carried round is a sensor that sees nothing; the LiDARs are mounted on it.
  Rig rig = nominal_rig();
  Sensor carrier;
  carrier.name = "carrier";
  carrier.camera.emplace();
  rig.sensors.insert(rig.sensors.begin(), carrier);
  rig.base = 0;
  rig.sensors[0].initial_T_base_sensor = SE3{};
  const auto plan = make_simulated_rig(rig, scene.T_scene_table, options.turntable, {}, options.seed);
  if (!plan) return plan.error();
  const RayCaster caster(scene);
  Random random(options.seed, thrown_stream);
  constexpr int tries = 1000;
  for (const SimulatedLidar& lidar : plan->lidars) {
    SE3 T = draw_mounting(random, mounting.reach_m);
    for (int k = 0; k < tries && mounting.sees_all_directions; ++k) {
      if (sees_all_directions(caster, plan->motion, lidar, T)) break;
      T = draw_mounting(random, mounting.reach_m);
    }
    rig.sensors[static_cast<std::size_t>(lidar.sensor)].initial_T_base_sensor = T;
  }
  LightRigOptions exact = options;
  exact.mount_error = {0.0, 0.0};
  Expected<LightRig> light = make_light_rig(scene, exact, rig);
  if (!light) return light;

  // Seen from the first LiDAR, and without the carrier.
  const SE3 T_base_carrier = light->T_base_sensor[1].inverse();
  light->T_base_sensor.erase(light->T_base_sensor.begin());
  for (SE3& T : light->T_base_sensor) T = T_base_carrier * T;
  light->T_base_sensor[0] = SE3{};
  for (SE3& T : light->T_G_base) T = T_base_carrier * T * T_base_carrier.inverse();
  for (Vector3d& step : light->step_rotations) step = T_base_carrier.R * step;
  light->axis = T_base_carrier.R * light->axis;
  light->axis_point = T_base_carrier * light->axis_point;
  light->axis_point -= light->axis_point.dot(light->axis) * light->axis;
  for (Patch& patch : light->patches) --patch.sensor;
  for (std::size_t i = 0; i < light->lidars.size(); ++i) {
    --light->lidars[i].sensor;
    light->lidars[i].T_base_sensor = light->T_base_sensor[i];
  }
  light->rig.sensors.erase(light->rig.sensors.begin());
  for (Sensor& sensor : light->rig.sensors) sensor.initial_T_base_sensor.reset();
  light->rig.sensors[0].initial_T_base_sensor = SE3{};
  return light;
}

}  // namespace rigcal::sim
