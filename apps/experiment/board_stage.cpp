#include "apps/experiment/board_stage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/edges/grey_image.h"
#include "simdata/camera/image_renderer.h"
#include "simdata/camera/image_sensor.h"
#include "simdata/scene/random_vectors.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal {
namespace {

constexpr double published_range_m = 0.015;
constexpr double published_grey = 0.007;
constexpr double enlarged = 1.33;
constexpr double free_behind_m = 0.3;
constexpr double full_well = 1e9;  // electrons: so many that light itself makes no noise

// x right, y down, z forward of a camera that looks along x of the rig.
Matrix3d looking_forward() {
  Matrix3d R;
  R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  return R;
}

double between(double reach, Random& random) { return random.uniform(-reach, reach); }

SE3 near_pose(const Matrix3d& R, const Vector3d& t, double turn_rad, Random& random) {
  const Vector3d turn = turn_rad * sim::random_direction(random);
  const Vector3d shift = 0.03 * sim::random_direction(random);
  return {exp_so3(turn) * R, t + shift};
}

// As automatic exposure has it: no more than one value in a thousand is brighter than four fifths of the largest.
double exposure_for(const sim::LightField& light, double usual_us) {
  std::vector<float> greys;
  for (std::size_t k = 0; k < light.pixels.size(); k += 7) greys.push_back(light.pixels[k].mean());
  const double brightest = of_rank(greys, greys.size() * 999 / 1000);
  return 0.8 * usual_us / std::max(1e-3, brightest);
}

sim::ImageSensor sensor_with(double grey_sigma, const sim::LightField& light) {
  sim::ImageSensor sensor;
  sensor.exposure_us = exposure_for(light, sensor.exposure_us);
  sensor.format_name = "Mono8";
  sensor.format = *parse_pixel_format(sensor.format_name);
  sensor.full_well = full_well;
  sensor.read_noise = grey_sigma * full_well;
  return sensor;
}

// The part of an image in which a board lies, with what is near it.
struct Window {
  int x = 0;
  int y = 0;
  int width = 0;
  int height = 0;
};

Window window_of(const CameraModel& camera, const SE3& T_camera_board, const BoardModel& board) {
  constexpr double near_px = 50.0;
  Eigen::AlignedBox2d box;
  for (const Vector3d& corner : board.plate_corners()) {
    if (const auto pixel = camera.project(T_camera_board * corner)) box.extend(*pixel);
  }
  const auto within = [](double v, int size) {
    return static_cast<int>(std::clamp(v, 0.0, static_cast<double>(size)));
  };
  const CameraIntrinsics& k = camera.intrinsics();
  Window out;
  out.x = within(box.min().x() - near_px, k.width - 1);
  out.y = within(box.min().y() - near_px, k.height - 1);
  out.width = std::max(1, within(box.max().x() + near_px, k.width) - out.x);
  out.height = std::max(1, within(box.max().y() + near_px, k.height) - out.y);
  return out;
}

sim::LightField light_of(const BoardStage& stage, const sim::Scene& scene, const sim::RayCaster& caster,
                         const BoardStation& station, const SE3& T_rig_board, const BoardModel& board) {
  const SE3 T_scene_camera = stage.T_scene_rig * station.T_rig_sensor;
  const CameraModel camera(*station.camera);
  if (!stage.is_bare) return sim::ImageRenderer(scene, caster, camera).render(T_scene_camera, 0.0);
  const Window window = window_of(camera, station.T_rig_sensor.inverse() * T_rig_board, board);
  CameraIntrinsics part = *station.camera;
  part.width = window.width;
  part.height = window.height;
  part.cx -= window.x;
  part.cy -= window.y;
  const sim::LightField seen = sim::ImageRenderer(scene, caster, CameraModel(part)).render(T_scene_camera, 0.0);
  sim::LightField out;
  out.width = station.camera->width;
  out.height = station.camera->height;
  for (int y = 0; y < out.height; ++y) {
    for (int x = 0; x < out.width; ++x) {
      out.pixels.push_back(
          seen.at(std::clamp(x - window.x, 0, seen.width - 1), std::clamp(y - window.y, 0, seen.height - 1)));
    }
  }
  return out;
}

void look_with_camera(const CameraIntrinsics& intrinsics, int station, const sim::LightField& light,
                      const ViewNoise& noise, const BoardModel& board, std::uint64_t seed, std::uint64_t frame,
                      std::vector<BoardSighting>& out) {
  const CameraModel camera(intrinsics);
  const Image image = sim::expose(light, sensor_with(noise.grey, light), seed, frame);
  for (ImageBoard& seen : find_image_boards(to_grey(image, 8), board).boards) {
    const auto pose = find_image_pose(seen, board, camera);
    if (pose) out.push_back(image_sighting(station, 0, std::move(seen), *pose, board, camera));
  }
}

}  // namespace

BoardSettings published_board() { return {"checkerboard", {10, 8}, 0.07, {0.77, 0.63}, {0.0, 0.0}}; }

CameraIntrinsics published_camera() {
  return {DistortionModel::radtan, 1280, 720, 640.0, 640.0, 639.5, 359.5, {0.0, 0.0, 0.0, 0.0, 0.0}};
}

std::vector<BoardStation> published_rig(Random& random) {
  const Matrix3d level = Matrix3d::Identity();
  std::vector<BoardStation> out(4);
  out[0] = {"lidar 1", near_pose(level, {0.0, 0.2, 0.1}, to_rad(3.0), random), std::nullopt};
  out[1] = {"lidar 2", near_pose(exp_so3({0.0, 0.0, to_rad(20.0)}), {0.0, -0.25, 0.05}, to_rad(3.0), random),
            std::nullopt};
  out[2] = {"camera 1", near_pose(looking_forward(), {0.1, 0.15, -0.1}, to_rad(3.0), random), published_camera()};
  out[3] = {"camera 2", near_pose(looking_forward(), {0.1, -0.15, -0.1}, to_rad(3.0), random), published_camera()};
  return out;
}

ViewNoise published_noise(int k) {
  const double root = std::sqrt(static_cast<double>(k));
  return {root * published_range_m, root * published_grey};
}

SE3 draw_board_pose(const PoseRange& range, Random& random) {
  const double bearing = between(range.bearing_rad, random);
  const double distance = random.uniform(range.near_m, range.far_m);
  const double height = between(range.height_m, random);
  const double lean = between(range.lean_rad, random);
  const double swing = between(range.lean_rad, random);
  const double side = random.uniform() < 0.5 ? -1.0 : 1.0;
  const double turn = side * to_rad(45.0) + between(range.turn_rad, random);
  SE3 T;
  T.R = exp_so3({0.0, 0.0, bearing}) * looking_forward() * exp_so3({lean, swing, 0.0}) * exp_so3({0.0, 0.0, turn});
  T.t = {distance * std::cos(bearing), distance * std::sin(bearing), height};
  return T;
}

bool is_in_all_images(const std::vector<BoardStation>& stations, const SE3& T_rig_board, const BoardModel& board,
                      double margin_px) {
  for (const BoardStation& station : stations) {
    if (!station.camera) continue;
    const CameraModel camera(*station.camera);
    const SE3 T = station.T_rig_sensor.inverse() * T_rig_board;
    for (const Vector3d& corner : board.plate_corners()) {
      const auto pixel = camera.project(T * corner);
      if (!pixel || !camera.contains(*pixel, margin_px)) return false;
    }
  }
  return true;
}

BoardStage bare_hall() {
  BoardStage out;
  sim::Material wall;
  wall.name = "wall";
  wall.reflectivity = 50.0;
  wall.color = Eigen::Array3f::Constant(0.3F);
  out.scene.name = "hall";
  out.scene.materials = {wall};
  sim::add_box(out.scene, {Matrix3d::Identity(), {4.0, 0.0, 2.0}}, {14.0, 10.0, 4.0}, 0);
  out.scene.light.sun = 0.0;
  out.scene.light.ambient = 0.8;
  out.T_scene_rig.t = {0.0, 0.0, 1.5};
  out.is_bare = true;
  return out;
}

bool stands_free(const BoardStage& stage, const std::vector<BoardStation>& stations, const SE3& T_rig_board,
                 const BoardModel& board) {
  const sim::RayCaster caster(stage.scene);
  const sim::RayCaster::People people = caster.people_at(0.0);
  constexpr int steps = 12;
  for (const BoardStation& station : stations) {
    const Vector3d from = stage.T_scene_rig * station.T_rig_sensor.t;
    for (int x = 0; x <= steps; ++x) {
      for (int y = 0; y <= steps; ++y) {
        const Vector3d on_plate(enlarged * board.size().x() * (static_cast<double>(x) / steps - 0.5),
                                enlarged * board.size().y() * (static_cast<double>(y) / steps - 0.5), 0.0);
        const Vector3d way = stage.T_scene_rig * (T_rig_board * on_plate) - from;
        if (caster.cast(from, way.normalized(), people, way.norm() + free_behind_m)) return false;
      }
    }
  }
  return true;
}

std::vector<std::vector<BoardSighting>> see_board(const BoardStage& stage, const std::vector<BoardStation>& stations,
                                                  const SE3& T_rig_board, const BoardSettings& settings,
                                                  const std::vector<ViewNoise>& noises, std::uint64_t seed) {
  const BoardModel board(settings);
  sim::Scene scene = stage.scene;
  sim::add_board(scene, stage.T_scene_rig * T_rig_board, settings, {}, 0.0);
  const sim::RayCaster caster(scene);
  std::vector<sim::LightField> light(stations.size());
  for (std::size_t s = 0; s < stations.size(); ++s) {
    if (!stations[s].camera) continue;
    light[s] = light_of(stage, scene, caster, stations[s], T_rig_board, board);
  }
  std::vector<std::vector<BoardSighting>> found(noises.size() * stations.size());
  parallel_for(found.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::size_t s = i % stations.size();
      const ViewNoise& noise = noises[i / stations.size()];
      const int station = static_cast<int>(s);
      if (stations[s].camera) {
        // Boards have consecutive seeds, so that only frames of their own keep one's noise from being another's.
        look_with_camera(*stations[s].camera, station, light[s], noise, board, seed + s, i, found[i]);
        continue;
      }
      Random random(seed, i);
      sim::SpinningLidar lidar;
      lidar.noise.range_sigma = lidar.noise.range_sigma_max = noise.range_m;
      const auto points =
          sim::spin_once(caster, scene.materials, stage.T_scene_rig * stations[s].T_rig_sensor, lidar, random);
      for (CloudBoard& seen : find_cloud_boards(points, board, true).boards) {
        found[i].push_back(cloud_sighting(station, 0, std::move(seen), board));
      }
    }
  });
  std::vector<std::vector<BoardSighting>> out(noises.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    auto& list = out[i / stations.size()];
    list.insert(list.end(), std::make_move_iterator(found[i].begin()), std::make_move_iterator(found[i].end()));
  }
  return out;
}

}  // namespace rigcal
