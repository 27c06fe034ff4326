#include "simdata/scene/scene_shapes.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simdata/scene/random_vectors.h"

namespace rigcal::sim {
namespace {

// A wall's own frame: s along it, h up, d outwards.
struct WallFrame {
  Vector3d foot;
  Vector3d along;
  Vector3d out;

  [[nodiscard]] Vector3d at(double s, double h, double d) const {
    return foot + s * along + h * Vector3d::UnitZ() + d * out;
  }
};

void add_wall_part(Scene& scene, const WallFrame& wall, double s0, double s1, double h0, double h1, double depth,
                   int material) {
  if (s1 - s0 < 1e-6 || h1 - h0 < 1e-6) return;
  scene.flats.push_back({wall.at(0.5 * (s0 + s1), 0.5 * (h0 + h1), -depth), 0.5 * (s1 - s0) * wall.along,
                         0.5 * (h1 - h0) * Vector3d::UnitZ(), false, material});
}

// The pane and the four reveals that lead to it.
void add_window(Scene& scene, const WallFrame& wall, double s0, double s1, double h0, double h1, const Windows& windows,
                int wall_material) {
  const double recess = windows.recess;
  add_wall_part(scene, wall, s0, s1, h0, h1, recess, windows.material);
  const Vector3d in = 0.5 * recess * wall.out;
  const Vector3d half_up = 0.5 * (h1 - h0) * Vector3d::UnitZ();
  const Vector3d half_along = 0.5 * (s1 - s0) * wall.along;
  for (const double s : {s0, s1})
    scene.flats.push_back({wall.at(s, 0.5 * (h0 + h1), -0.5 * recess), in, half_up, false, wall_material});
  for (const double h : {h0, h1})
    scene.flats.push_back({wall.at(0.5 * (s0 + s1), h, -0.5 * recess), in, half_along, false, wall_material});
}

}  // namespace

void add_box(Scene& scene, const SE3& T_scene_box, const Vector3d& size, int material) {
  for (int axis = 0; axis < 3; ++axis) {
    const int next = (axis + 1) % 3;
    const int last = (axis + 2) % 3;
    for (const double sign : {-0.5, 0.5}) {
      const Vector3d center = T_scene_box * Vector3d(sign * size[axis] * Vector3d::Unit(axis));
      scene.flats.push_back({center, 0.5 * size[next] * T_scene_box.R.col(next),
                             0.5 * size[last] * T_scene_box.R.col(last), false, material});
    }
  }
}

void add_rectangle(Scene& scene, const SE3& T_scene_flat, double size_x, double size_y, int material) {
  scene.flats.push_back(
      {T_scene_flat.t, 0.5 * size_x * T_scene_flat.R.col(0), 0.5 * size_y * T_scene_flat.R.col(1), false, material});
}

void add_cylinder(Scene& scene, const Cylinder& cylinder) {
  scene.cylinders.push_back(cylinder);
  const Vector3d u = cylinder.axis.unitOrthogonal() * cylinder.radius;
  const Vector3d v = cylinder.axis.cross(u);
  for (const double end : {0.0, cylinder.length})
    scene.flats.push_back({cylinder.base + end * cylinder.axis, u, v, true, cylinder.material});
}

void add_facade(Scene& scene, const Vector3d& from, const Vector3d& to, double height, const Windows& windows,
                int material) {
  const double length = (to - from).norm();
  const Vector3d along = (to - from) / length;
  const WallFrame wall{from, along, along.cross(Vector3d::UnitZ())};
  double below = 0.0;  // height up to which the wall is built
  for (int row = 0; row < windows.rows && windows.count > 0; ++row) {
    const double h0 = windows.sill + row * windows.row_pitch;
    const double h1 = h0 + windows.height;
    if (h0 < below || h1 > height) break;
    add_wall_part(scene, wall, 0.0, length, below, h0, 0.0, material);
    const double pitch = length / windows.count;
    double built = 0.0;
    for (int column = 0; column < windows.count; ++column) {
      const double s0 = std::max((column + 0.5) * pitch - 0.5 * windows.width, built);
      const double s1 = std::min(s0 + windows.width, length);
      add_wall_part(scene, wall, built, s0, h0, h1, 0.0, material);
      add_window(scene, wall, s0, s1, h0, h1, windows, material);
      built = s1;
    }
    add_wall_part(scene, wall, built, length, h0, h1, 0.0, material);
    below = h1;
  }
  add_wall_part(scene, wall, 0.0, length, below, height, 0.0, material);
}

void add_stairs(Scene& scene, const SE3& T_scene_stairs, int steps, double rise, double tread, double width,
                int material) {
  for (int step = 0; step < steps; ++step) {
    const Vector3d size((steps - step) * tread, width, rise);
    const SE3 T_stairs_step{Matrix3d::Identity(), Vector3d(step * tread + 0.5 * size.x(), 0.0, (step + 0.5) * rise)};
    add_box(scene, T_scene_stairs * T_stairs_step, size, material);
  }
}

void add_foliage(Scene& scene, const Vector3d& center, const Vector3d& radii, int count, std::array<double, 2> size,
                 std::uint64_t seed, int material) {
  Random random(seed, 0x1eaf);
  for (int leaf = 0; leaf < count; ++leaf) {
    // The root of a uniform number fills the outer half more, as crowns do.
    const Vector3d outwards = random_direction(random);
    const double depth = std::sqrt(random.uniform());
    const Vector3d normal = random_direction(random);
    const double length = random.uniform(size[0], size[1]);
    const double width = random.uniform(size[0], size[1]);
    const Vector3d along = normal.unitOrthogonal();
    scene.flats.push_back(
        {center + depth * radii.cwiseProduct(outwards), length * along, width * normal.cross(along), true, material});
  }
}

void add_rocks(Scene& scene, const std::array<double, 4>& area, double z, int count, std::array<double, 2> size,
               std::uint64_t seed, int material) {
  Random random(seed, 0x57011e);
  for (int rock = 0; rock < count; ++rock) {
    const double x = random.uniform(area[0], area[2]);
    const double y = random.uniform(area[1], area[3]);
    const Vector3d axis = random_direction(random);
    const Matrix3d R = exp_so3(axis * random.uniform(0.0, pi));
    Vector3d half;
    for (int i = 0; i < 3; ++i) half[i] = random.uniform(size[0], size[1]);
    add_box(scene, {R, Vector3d(x, y, z)}, 2.0 * half, material);
  }
}

}  // namespace rigcal::sim
