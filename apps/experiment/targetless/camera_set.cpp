#include "apps/experiment/targetless/camera_set.h"

#include <utility>

#include "core/base/parallel.h"
#include "core/base/seconds.h"
#include "core/camera/working_size.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/camera/camera_shots.h"
#include "simdata/camera/image_renderer.h"
#include "simdata/rig/light_rig.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t odometry_stream = 960;
constexpr double pose_error_m = 0.02;
constexpr double pose_error_deg = 0.2;

Sensor camera_sensor(const std::string& name, double y_m, double scale) {
  Sensor sensor;
  sensor.name = name;
  CameraSettings camera;
  camera.driver = "images";
  camera.pixel_format = "Mono8";
  camera.exposure_us = 5000.0;
  CameraIntrinsics& intrinsics = camera.intrinsics.emplace();
  intrinsics.width = static_cast<int>(1280 * scale);
  intrinsics.height = static_cast<int>(1024 * scale);
  intrinsics.fx = 863.0 * scale;
  intrinsics.fy = 863.0 * scale;
  intrinsics.cx = 0.5 * (intrinsics.width - 1);
  intrinsics.cy = 0.5 * (intrinsics.height - 1);
  intrinsics.distortion.assign(5, 0.0);
  sensor.camera = camera;
  Matrix3d forward;  // x right, y down, z forward in a frame with x forward, y left, z up
  forward << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  sensor.initial_T_base_sensor = SE3{forward, {0.05, y_m, -0.05}};
  return sensor;
}

Rig rig_with_cameras(double scale) {
  Rig rig = sim::nominal_rig();
  std::erase_if(rig.sensors,
                [](const Sensor& sensor) { return sensor.name == "mid100_left" || sensor.name == "mid100_right"; });
  rig.sensors.push_back(camera_sensor("camera_left", 0.06, scale));
  rig.sensors.push_back(camera_sensor("camera_right", -0.06, scale));
  return rig;
}

// A run, and what is needed to look at it again.
struct Run {
  sim::Scene scene;
  sim::LightRigOptions options;
  sim::LightRig light;
};

Expected<Run> make_run(const CameraSetOptions& options) {
  Expected<sim::Scene> scene = sim::load_scene(options.scene);
  if (!scene) return scene.error();
  Run run;
  run.scene = std::move(*scene);
  run.options.seed = options.seed;
  run.options.shots_per_patch = options.points;
  run.options.turntable.stops = options.stops;
  Expected<sim::LightRig> light = sim::make_light_rig(run.scene, run.options, rig_with_cameras(options.image_scale));
  if (!light) return light.error();
  run.light = std::move(*light);
  return run;
}

// Every camera's images and their edges, as sim::write_patch_images exposes them.
Expected<std::vector<CameraTask>> take_images(const Run& run, int images, const RunContext& context) {
  const auto simulated = sim::make_simulated_rig(run.light.rig, run.scene.T_scene_table, run.options.turntable,
                                                 run.options.mount_error, run.options.seed, run.options.unit_errors);
  if (!simulated) return simulated.error();
  const auto cameras = sim::simulated_cameras(run.light.rig, simulated->T_base_sensor);
  if (!cameras) return cameras.error();
  const sim::RayCaster caster(run.scene);
  const int stops = simulated->motion.stop_count();
  const int wanted = std::min(images, stops);
  std::vector<CameraTask> out;
  for (const sim::SimulatedCamera& camera : *cameras) {
    const int halvings = halvings_of(camera.model.intrinsics());
    CameraTask task{camera.sensor, camera.name, halved(camera.model.intrinsics(), halvings), std::nullopt, {}};
    const sim::ImageRenderer renderer(run.scene, caster, camera.model);
    for (int k = 0; k < wanted; ++k) {
      if (context.cancelled()) return cancelled_error();
      context.reporter.progress(camera.name + " images", static_cast<double>(k) / wanted);
      const int stop = k * stops / wanted;
      const double time_s = simulated->motion.stop_start_s(stop) + 0.5 * simulated->motion.dwell_s(stop);
      const SE3 T_scene_camera = simulated->motion.T_scene_base_unswung(time_s) * camera.T_base_camera;
      const Image image = sim::expose(renderer.render(T_scene_camera, time_s), camera.chip, run.options.seed,
                                      camera.noise_of(static_cast<std::uint64_t>(stop)));
      ImageFeatures features = find_features(image, halvings);
      task.views.push_back({stop, camera.name + " " + std::to_string(stop), std::move(features.grey), features.edges});
    }
    out.push_back(std::move(task));
  }
  return out;
}

// What one LiDAR of the run saw, as if it were alone, with rough poses of its own; and how long its cells took.
LidarRecording alone(const Run& run, int sensor, double& cells_s) {
  LidarRecording out;
  out.lidar_sensors = {sensor};
  std::vector<Patch> patches;
  for (const Patch& patch : run.light.patches) {
    if (patch.sensor == sensor) patches.push_back({0, patch.stop, patch.points});
  }
  CellOptions cells;
  cells.keep_thinned = true;
  const auto begin = SteadyClock::now();
  out.patches = cells_of_patches(patches, cells);
  cells_s = seconds_since(begin);
  Random random(run.options.seed, odometry_stream + static_cast<std::uint64_t>(sensor));
  const SE3& E = run.light.T_base_sensor[static_cast<std::size_t>(sensor)];
  const SE3 T_first = run.light.T_G_base.front() * E;
  for (std::size_t j = 0; j < run.light.T_G_base.size(); ++j) {
    out.stops.push_back({static_cast<int>(j), 0, 0});
    const SE3 T = T_first.inverse() * (run.light.T_G_base[j] * E);
    const Vector3d turn = to_rad(pose_error_deg) * sim::random_normal3(random);
    const Vector3d shift = pose_error_m * sim::random_normal3(random);
    out.trajectory.emplace_back(j == 0 ? T : T * SE3{exp_so3(turn), shift});
  }
  return out;
}

Expected<CameraSide> make_side(const Run& run, int sensor, const std::vector<CameraTask>& cameras,
                               const RunContext& context) {
  CameraSide out;
  Rig rig = run.light.rig;
  rig.base = sensor;
  out.lidar = rig.sensors[static_cast<std::size_t>(sensor)].name;
  LidarRecording recording = alone(run, sensor, out.cells_s);
  LidarCalibrationOptions options;
  options.with_map = false;
  SilentReporter silent;
  const auto result = calibrate_lidars(rig, recording, {SE3{}}, options, {silent, context.stop}, &out.solution);
  if (!result) return result.error();
  out.scene = make_camera_scene(rig, recording, *out.solution, context.stop);
  out.patches = std::move(recording.patches);
  out.cameras = cameras;
  const SE3 T_lidar_base = run.light.T_base_sensor[static_cast<std::size_t>(sensor)].inverse();
  for (const CameraTask& camera : cameras)
    out.T_lidar_camera.push_back(T_lidar_base * run.light.T_base_sensor[static_cast<std::size_t>(camera.sensor)]);
  return out;
}

}  // namespace

Expected<std::vector<CameraSide>> make_camera_sides(const CameraSetOptions& options, const RunContext& context) {
  if (context.cancelled()) return cancelled_error();
  const Expected<Run> run = make_run(options);
  if (!run) return run.error();
  const Expected<std::vector<CameraTask>> cameras = take_images(*run, options.images, context);
  if (!cameras) return cameras.error();
  std::vector<CameraSide> out;
  for (const sim::SimulatedLidar& lidar : run->light.lidars) {
    context.reporter.progress("maps of the cameras", -1.0);
    Expected<CameraSide> side = make_side(*run, lidar.sensor, *cameras, context);
    if (!side) return side.error();
    side->overlaps = lidar.sensor == run->light.rig.base;
    out.push_back(std::move(*side));
  }
  return out;
}

}  // namespace rigcal::targetless
