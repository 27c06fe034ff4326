#include "simdata/targets/board_views.h"

#include <algorithm>
#include <cmath>

#include "simdata/lidar/shot_meter.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

constexpr double stand_behind_m = 0.35;
constexpr double stand_radius_m = 0.015;

int add_material(Scene& scene, const std::string& name, double reflectivity, float grey) {
  Material material;
  material.name = name;
  material.reflectivity = reflectivity;
  material.color = Eigen::Array3f::Constant(grey);
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

// The rectangle from (x0, y0) to (x1, y1) of the board's plane.
void add_part(Scene& scene, const SE3& T, double x0, double x1, double y0, double y1, int material) {
  if (x1 - x0 < 1e-6 || y1 - y0 < 1e-6) return;
  const Vector3d center = T * Vector3d(0.5 * (x0 + x1), 0.5 * (y0 + y1), 0.0);
  scene.flats.push_back({center, 0.5 * (x1 - x0) * T.R.col(0), 0.5 * (y1 - y0) * T.R.col(1), false, material});
}

void add_stand(Scene& scene, const SE3& T, double ground_m, int material) {
  Vector3d back = T.R.col(2);
  back.z() = 0.0;
  const Vector3d top = T.t + stand_behind_m * back.normalized();
  const Vector3d arm = top - T.t;
  // The arm begins behind the plate.
  scene.cylinders.push_back({T.t + 0.05 * arm, arm.normalized(), 0.95 * arm.norm(), stand_radius_m, material});
  if (top.z() > ground_m) {
    scene.cylinders.push_back(
        {{top.x(), top.y(), ground_m}, Vector3d::UnitZ(), top.z() - ground_m, stand_radius_m, material});
  }
}

}  // namespace

void add_board(Scene& scene, const SE3& T_scene_board, const BoardSettings& board, const BoardLook& look,
               double ground_m) {
  const int dark = add_material(scene, "dark square", look.dark_reflectivity, look.dark);
  const int bright = add_material(scene, "bright square", look.bright_reflectivity, look.bright);
  const int columns = board.inner_corners[0] + 1;
  const int rows = board.inner_corners[1] + 1;
  const double half_x = 0.5 * board.square * columns;
  const double half_y = 0.5 * board.square * rows;
  const double x0 = board.offset[0] - half_x;
  const double y0 = board.offset[1] - half_y;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      add_part(scene, T_scene_board, x0 + column * board.square, x0 + (column + 1) * board.square,
               y0 + row * board.square, y0 + (row + 1) * board.square, (row + column) % 2 == 0 ? dark : bright);
    }
  }
  const double x1 = x0 + 2.0 * half_x;
  const double y1 = y0 + 2.0 * half_y;
  const double edge_x = std::max(0.5 * board.size[0], half_x);
  const double edge_y = std::max(0.5 * board.size[1], half_y);
  add_part(scene, T_scene_board, -edge_x, x0, -edge_y, edge_y, bright);
  add_part(scene, T_scene_board, x1, edge_x, -edge_y, edge_y, bright);
  add_part(scene, T_scene_board, x0, x1, -edge_y, y0, bright);
  add_part(scene, T_scene_board, x0, x1, y1, edge_y, bright);
  add_stand(scene, T_scene_board, ground_m, dark);
}

std::vector<Point> spin_once(const RayCaster& caster, const std::vector<Material>& materials, const SE3& T_scene_lidar,
                             const SpinningLidar& lidar, Random& random) {
  const ShotMeter meter(caster, materials, lidar.noise);
  const RayCaster::People people = caster.people_at(0.0);
  const int steps = static_cast<int>(std::floor(2.0 * pi / lidar.azimuth_step_rad));
  const double first = random.uniform(0.0, lidar.azimuth_step_rad);
  std::vector<Point> out;
  for (int ring = 0; ring < lidar.rings; ++ring) {
    const double elevation = lidar.lowest_rad + ring * lidar.ring_step_rad;
    for (int k = 0; k < steps; ++k) {
      const double azimuth = first + k * lidar.azimuth_step_rad;
      const Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
      const Shot shot = meter.measure(T_scene_lidar, ray, people, random);
      if (shot.count == 0) continue;
      Point& point = out.emplace_back(to_point(shot.direction, shot.single(false)));
      point.shot = static_cast<std::uint16_t>(ring);
    }
  }
  return out;
}

std::vector<Point> stare(const RayCaster& caster, const std::vector<Material>& materials, const SE3& T_scene_lidar,
                         const PrismScanner& scanner, const LidarNoise& noise, double seconds, int shots,
                         Random& random) {
  const ShotMeter meter(caster, materials, noise);
  const RayCaster::People people = caster.people_at(0.0);
  const double fired = std::floor(seconds * scanner.shots_per_s());
  const int count = static_cast<int>(std::min<double>(shots, fired));
  std::vector<Point> out;
  for (int k = 0; k < count; ++k) {
    // A random shot out of each share of the stop: an even stride would beat with the laser lines.
    const double place = (k + random.uniform()) * fired / count;
    const Vector3d ray = scanner.direction(static_cast<std::int64_t>(place));
    const Shot shot = meter.measure(T_scene_lidar, ray, people, random);
    if (shot.count > 0) out.push_back(to_point(shot.direction, shot.single(false)));
  }
  return out;
}

}  // namespace rigcal::sim
