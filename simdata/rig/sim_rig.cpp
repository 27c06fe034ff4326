#include "simdata/rig/sim_rig.h"

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/scene/random_vectors.h"

namespace rigcal::sim {
namespace {

// One random stream a purpose, so that a change of one does not shift the others.
enum Stream : std::uint64_t { motion_stream = 1, mount_stream = 100, scan_stream = 200, unit_stream = 600 };

SE3 draw_mounting(const Sensor& sensor, const MountError& error, Random& random) {
  if (sensor.initial_T_base_sensor) {
    const SE3& nominal = *sensor.initial_T_base_sensor;
    const Vector3d turn = to_rad(error.rotation_deg) * random_direction(random);
    const Vector3d shift = error.translation_m * random_direction(random);
    return {nominal.R * exp_so3(turn), nominal.t + shift};
  }
  const double yaw = random.uniform(-pi, pi);
  const double tilt = to_rad(random.uniform(0.0, 10.0));
  const Vector3d tilt_axis = random_level_direction(random);
  const double distance = random.uniform(0.0, 0.3);
  return {exp_so3(yaw * Vector3d::UnitZ()) * exp_so3(tilt * tilt_axis), distance * random_direction(random)};
}

void add_unit_errors(const UnitErrorOptions& options, std::uint64_t seed, SimulatedLidar& lidar) {
  Random random(seed, unit_stream + static_cast<std::uint64_t>(lidar.sensor));
  lidar.noise.range_bias = options.range_bias_sigma_m * random.normal();
  lidar.noise.dark_bias = options.dark_bias_m;
  lidar.noise.second_ray_share = options.footprint_share;
  lidar.wobble = {options.wobble_rad, lidar.scanner.first_prism_turns_per_s(), random.uniform()};
}

SE3 backward(double yaw_deg, double y) {
  return {exp_so3(to_rad(180.0 + yaw_deg) * Vector3d::UnitZ()), Vector3d(-0.15, y, -0.1)};
}

Sensor lidar_sensor(std::string name, LidarModel model, std::string code, std::uint8_t last_of_ip) {
  Sensor sensor;
  sensor.name = std::move(name);
  sensor.lidar.emplace();
  sensor.lidar->model = model;
  sensor.lidar->broadcast_code = std::move(code);
  sensor.lidar->ip = std::array<std::uint8_t, 4>{192, 168, 1, last_of_ip};
  return sensor;
}

}  // namespace

Rig nominal_rig() {
  Rig rig;
  rig.name = "nominal";
  rig.sensors.push_back(lidar_sensor("avia", LidarModel::livox_avia, "3JEDHC900100791", 179));
  rig.sensors.push_back(lidar_sensor("mid100_left", LidarModel::livox_mid40, "0TFDG3B00600551", 21));
  rig.sensors.push_back(lidar_sensor("mid100_middle", LidarModel::livox_mid40, "0TFDG3B00600552", 91));
  rig.sensors.push_back(lidar_sensor("mid100_right", LidarModel::livox_mid40, "0TFDG3B00600553", 161));
  rig.sensors[0].initial_T_base_sensor = SE3{};
  rig.sensors[1].initial_T_base_sensor = backward(30.0, -0.06);
  rig.sensors[2].initial_T_base_sensor = backward(0.0, 0.0);
  rig.sensors[3].initial_T_base_sensor = backward(-30.0, 0.06);
  return rig;
}

Expected<SimulatedRig> make_simulated_rig(const Rig& rig, const SE3& T_scene_table, const TurntableOptions& turntable,
                                          const MountError& error, std::uint64_t seed,
                                          const UnitErrorOptions& unit_errors) {
  Random motion_random(seed, motion_stream);
  SimulatedRig simulated{{}, {}, TurntableMotion(T_scene_table, turntable, motion_random)};
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const Sensor& sensor = rig.sensors[i];
    Random mount_random(seed, mount_stream + i);
    Random scan_random(seed, scan_stream + i);
    const bool is_base = static_cast<int>(i) == rig.base;
    simulated.T_base_sensor.push_back(is_base ? SE3{} : draw_mounting(sensor, error, mount_random));
    if (!sensor.is_lidar()) continue;
    const auto scanner = PrismScanner::of(sensor.lidar->model, scan_random);
    if (!scanner)
      return input_error("how a LiDAR of the type 'lidar' scans is not known",
                         "sensor '" + sensor.name + "' of the rig",
                         "simulate LiDARs of Livox: livox_avia, livox_mid40 and so on");
    simulated.lidars.push_back(
        {static_cast<int>(i), simulated.T_base_sensor.back(), *scanner, LidarNoise::of(sensor.lidar->model), {}});
    add_unit_errors(unit_errors, seed, simulated.lidars.back());
  }
  return simulated;
}

}  // namespace rigcal::sim
