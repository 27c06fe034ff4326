#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/voxel/cells.h"
#include "core/voxel/noise_model.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// A flat rectangle in the world: center + a u + b v with |a|, |b| <= 1.
struct Wall {
  Vector3d center = Vector3d::Zero();
  Vector3d u = Vector3d::UnitX();
  Vector3d v = Vector3d::UnitY();

  [[nodiscard]] Vector3d normal() const { return u.cross(v).normalized(); }
  [[nodiscard]] double area_m2() const { return 4.0 * u.cross(v).norm(); }
};

/// A room of 8 x 6 x 3 m around the origin with four leaning boards and a niche, so that it looks like itself from one
/// side only.
inline std::vector<Wall> make_room() {
  const auto x = [](double s) -> Vector3d { return s * Vector3d::UnitX(); };
  const auto y = [](double s) -> Vector3d { return s * Vector3d::UnitY(); };
  const auto z = [](double s) -> Vector3d { return s * Vector3d::UnitZ(); };
  std::vector<Wall> walls{{z(-1.3), x(4), y(3)},         {z(1.7), x(4), y(3)},           {x(-4) + z(0.2), y(3), z(1.5)},
                          {x(4) + z(0.2), y(3), z(1.5)}, {y(-3) + z(0.2), x(4), z(1.5)}, {y(3) + z(0.2), x(4), z(1.5)}};
  walls.push_back({x(2.5) + y(1.5), x(0.5) - y(0.5), z(1.0) + x(0.2)});
  walls.push_back({x(-2.8) + y(0.7), x(0.2) + y(0.6), z(0.9) - y(0.1)});
  walls.push_back({x(-1.0) - y(2.2), x(0.7) + y(0.2), z(0.8) + y(0.4)});
  walls.push_back({x(2.8) - y(1.6) - z(0.5), x(0.6) + z(0.1), y(0.8) + z(0.2)});
  walls.push_back({x(1.0) + y(2.3) + z(0.3), y(0.7), z(1.0)});
  return walls;
}

/// The point p (sensor frame) as a LiDAR of that noise measures it.
inline Point measured(const Vector3d& p_sensor, const NoiseModel& noise, Random& random) {
  const double r = p_sensor.norm();
  const Vector3d ray = p_sensor / r;
  const Vector3d across1 = ray.unitOrthogonal();
  const Vector3d across2 = ray.cross(across1);
  const double along = noise.range_m * random.normal();
  const double along_per_m = noise.range_per_m * random.normal();
  const double a1 = noise.angle_rad * random.normal();
  const double a2 = noise.angle_rad * random.normal();
  const Vector3d p = (r + along + along_per_m * r) * ray + r * (a1 * across1 + a2 * across2);
  Point point;
  point.x = static_cast<float>(p.x());
  point.y = static_cast<float>(p.y());
  point.z = static_cast<float>(p.z());
  return point;
}

struct View {
  double points_per_m2 = 100.0;
  double half_angle_rad = pi;  ///< Of the cone about the sensor's x axis that it sees.
  NoiseModel noise;
};

/// What a sensor at T_G_sensor sees of the walls; none stands in front of another.
inline std::vector<Point> see(const std::vector<Wall>& walls, const SE3& T_G_sensor, const View& view, Random& random) {
  std::vector<Point> points;
  const SE3 T_sensor_G = T_G_sensor.inverse();
  const double least_x = std::cos(view.half_angle_rad);
  for (const Wall& wall : walls) {
    const int count = static_cast<int>(std::lround(view.points_per_m2 * wall.area_m2()));
    for (int k = 0; k < count; ++k) {
      const double a = random.uniform(-1.0, 1.0);
      const double b = random.uniform(-1.0, 1.0);
      const Vector3d p = T_sensor_G * (wall.center + a * wall.u + b * wall.v);
      if (p.x() < least_x * p.norm()) continue;
      points.push_back(measured(p, view.noise, random));
    }
  }
  return points;
}

inline PatchCells cells_of(const std::vector<Point>& points, int lidar, int stop, const CellOptions& options = {}) {
  CellBuilder builder(lidar, stop, options);
  builder.add(points);
  return builder.finish();
}

/// One patch for each stop and LiDAR of `state`, by stop, then by LiDAR.
inline std::vector<PatchCells> make_patches(const std::vector<Wall>& walls, const RigState& state, const View& view,
                                            Random& random) {
  std::vector<PatchCells> patches;
  for (int j = 0; j < static_cast<int>(state.T_G_base.size()); ++j) {
    for (int i = 0; i < static_cast<int>(state.T_base_sensor.size()); ++i) {
      patches.push_back(cells_of(see(walls, state.T_G_sensor(j, i), view, random), i, j));
    }
  }
  return patches;
}

/// A rig on a table: `stops` steps of a full turn about an upright axis through `foot`, and two LiDARs back to back.
inline RigState turning_rig(int stops, const Vector3d& foot) {
  RigState state;
  for (int j = 0; j < stops; ++j) {
    const Matrix3d R = exp_so3(2.0 * pi * j / stops * Vector3d::UnitZ());
    state.T_G_base.push_back({R, foot - R * foot});
  }
  state.T_base_sensor = {SE3{}, {exp_so3(Vector3d(0.1, -0.05, 2.6)), Vector3d(-0.15, 0.06, -0.1)}};
  return state;
}

}  // namespace rigcal
