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

}  // namespace

double EdgePoint::variance_along(const Vector3d& n, const NoiseModel& noise) const {
  return noise.variance_along(static_cast<double>(range_m) * ray_G.cast<double>(), n);
}

EdgePoints::EdgePoints(const std::vector<EdgePiece>& pieces, const std::vector<PatchCells>& patches,
                       const RigState& state, const std::vector<char>& use, double reach_m)
    : cubes_(wanted_cubes(pieces, reach_m)) {
  std::vector<std::vector<std::pair<std::uint32_t, EdgePoint>>> of_patch(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use.empty() && !use[k]) continue;
      const SE3 T = state.T_G_sensor(patches[k].stop, patches[k].lidar);
      for (const Point& point : patches[k].thinned) {
        const Vector3d p(point.x, point.y, point.z);
        const Vector3d g = T * p;
        const std::uint32_t cube = cubes_.find(cube_number(cube_place(g, per_m)));
        if (cube == KeyNumbers::unknown) continue;
        const double range = p.norm();
        of_patch[k].push_back({cube,
                               {g.cast<float>(), (T.R * p / range).cast<float>(), static_cast<float>(range),
                                static_cast<std::uint16_t>(patches[k].lidar)}});
      }
    }
  });
  starts_.assign(std::size_t{cubes_.size()} + 1, 0);
  for (const auto& part : of_patch) {
    for (const auto& [cube, point] : part) ++starts_[cube + 1];
  }
  for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
  std::vector<std::size_t> next(starts_.begin(), starts_.end() - 1);
  points_.resize(starts_.back());
  for (auto& part : of_patch) {
    for (const auto& [cube, point] : part) points_[next[cube]++] = point;
    part = {};
  }
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
