#include "core/edges/edge_points.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/edges/cube_grid.h"

namespace rigcal {
namespace {

constexpr double cube_m = 0.25;
constexpr double per_m = 1.0 / cube_m;

template <class Visit>
void for_each_cube(const CubePlace& low, const CubePlace& high, const Visit& visit) {
  for (std::int64_t x = low.x; x <= high.x; ++x) {
    for (std::int64_t y = low.y; y <= high.y; ++y) {
      for (std::int64_t z = low.z; z <= high.z; ++z) visit(cube_number({x, y, z}));
    }
  }
}

// Numbers of all cubes that come within `reach_m` of a place in the cube of any piece's middle.
KeyNumbers wanted_cubes(const std::vector<EdgePiece>& pieces, double reach_m) {
  const auto steps = static_cast<std::int64_t>(std::ceil(reach_m * per_m));
  KeyNumbers middles;
  KeyNumbers cubes;
  for (const EdgePiece& piece : pieces) {
    const CubePlace at = cube_place(piece.middle, per_m);
    if (!middles.meet(cube_number(at)).first) continue;
    for_each_cube({at.x - steps, at.y - steps, at.z - steps}, {at.x + steps, at.y + steps, at.z + steps},
                  [&](std::uint64_t key) { cubes.meet(key); });
  }
  return cubes;
}

EdgePoint edge_point(const Point& point, const SE3& T_G_sensor, int lidar) {
  const Vector3d p(point.x, point.y, point.z);
  const double range = p.norm();
  return {(T_G_sensor * p).cast<float>(), (T_G_sensor.R * p / range).cast<float>(), static_cast<float>(range),
          static_cast<std::uint16_t>(lidar)};
}

}  // namespace

double EdgePoint::variance_along(const Vector3d& n, const NoiseModel& noise) const {
  return noise.variance_along(static_cast<double>(range_m) * ray_G.cast<double>(), n);
}

EdgePoints::EdgePoints(const std::vector<EdgePiece>& pieces, const std::vector<PatchCells>& patches,
                       const RigState& state, const std::vector<char>& use, double reach_m)
    : cubes_(wanted_cubes(pieces, reach_m)) {
  std::vector<SE3> T_G_sensor;
  for (const PatchCells& patch : patches) T_G_sensor.push_back(state.T_G_sensor(patch.stop, patch.lidar));
  std::vector<std::vector<std::uint32_t>> cube_of(patches.size());  // of each point of each patch
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use.empty() && !use[k]) continue;
      cube_of[k].reserve(patches[k].thinned.size());
      for (const Point& point : patches[k].thinned) {
        const Vector3d g = T_G_sensor[k] * Vector3d(point.x, point.y, point.z);
        cube_of[k].push_back(cubes_.find(cube_number(cube_place(g, per_m))));
      }
    }
  });
  starts_.assign(std::size_t{cubes_.size()} + 1, 0);
  for (const std::vector<std::uint32_t>& of_patch : cube_of) {
    for (const std::uint32_t cube : of_patch) {
      if (cube != KeyNumbers::unknown) ++starts_[cube + 1];
    }
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  points_.resize(starts_.back());
  // Each chunk of cubes takes its own from all patches: far fewer bytes than points that are dealt out twice.
  constexpr std::size_t chunks = 16;
  const std::size_t grain = cubes_.size() / chunks + 1;
  parallel_for(cubes_.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<std::size_t> next(starts_.begin() + static_cast<std::ptrdiff_t>(begin),
                                  starts_.begin() + static_cast<std::ptrdiff_t>(end));
    for (std::size_t k = 0; k < patches.size(); ++k) {
      for (std::size_t i = 0; i < cube_of[k].size(); ++i) {
        const std::size_t cube = cube_of[k][i];
        if (cube < begin || cube >= end) continue;
        points_[next[cube - begin]++] = edge_point(patches[k].thinned[i], T_G_sensor[k], patches[k].lidar);
      }
    }
  });
}

void EdgePoints::around(const Vector3d& p, double radius_m, std::vector<std::span<const EdgePoint>>& found) const {
  const Vector3d reach = Vector3d::Constant(radius_m);
  for_each_cube(cube_place(p - reach, per_m), cube_place(p + reach, per_m), [&](std::uint64_t key) {
    const std::uint32_t cube = cubes_.find(key);
    if (cube == KeyNumbers::unknown || starts_[cube] == starts_[cube + 1]) return;
    found.push_back(std::span(points_).subspan(starts_[cube], starts_[cube + 1] - starts_[cube]));
  });
}

}  // namespace rigcal
