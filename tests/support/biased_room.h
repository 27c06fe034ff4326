#pragma once

#include <cmath>
#include <vector>

#include "core/planes/refine.h"
#include "core/voxel/range_correction.h"
#include "tests/support/make_cells.h"

namespace rigcal {

// A room seen by two LiDARs from eight stops of a full turn, each with its own error of the ranges. Its walls have
// stripes of a metre, dark and bright.
struct BiasedRoom {
  RigState truth = turning_rig(8, Vector3d(0.25, 0.1, 0.0));
  std::vector<PatchCells> patches;
  std::vector<NoiseModel> noise{2, NoiseModel{0.01, 0.0, 0.0005}};
  ParameterLayout layout{8, 2};
  SE3 T_grid_G{exp_so3(Vector3d(0.3, 0.2, 0.5)), Vector3d(0.5, 0.7, 0.9)};

  BiasedRoom(std::uint64_t seed, const std::vector<RangeError>& too_long, double points_per_m2 = 200.0) {
    Random random(seed);
    for (int stop = 0; stop < 8; ++stop) {
      for (int lidar = 0; lidar < 2; ++lidar) {
        const SE3 T_G_sensor = truth.T_G_sensor(stop, lidar);
        std::vector<Point> points = see(make_room(), T_G_sensor, View{points_per_m2, to_rad(40.0), noise[0]}, random);
        for (Point& p : points) {
          const Vector3d at(p.x, p.y, p.z);
          const Vector3d world = T_G_sensor * at;
          p.reflectivity = std::sin(pi * (world.x() + 0.4)) * std::sin(pi * (world.y() + 0.4)) < 0.0 ? 10 : 60;
          const double error_m = too_long[static_cast<std::size_t>(lidar)].at(p.reflectivity == 10 ? 0.9 : 0.4);
          const Vector3d wrong = at + error_m * at.normalized();
          p.x = static_cast<float>(wrong.x());
          p.y = static_cast<float>(wrong.y());
          p.z = static_cast<float>(wrong.z());
        }
        patches.push_back(cells_of(points, lidar, stop));
      }
    }
    for (int j = 1; j < 8; ++j) layout.free_stop(j);
    layout.free_lidar(1);
  }

  // Of the second LiDAR's place, m.
  [[nodiscard]] double error_of(const RigState& state) const {
    return (state.T_base_sensor[1].t - truth.T_base_sensor[1].t).norm();
  }
  RefineSummary solve(RigState& state) const {
    SilentReporter reporter;
    return *refine({patches, noise, T_grid_G, {}, {}}, layout, standard_passes(3), RunContext{reporter}, state);
  }
};

}  // namespace rigcal
