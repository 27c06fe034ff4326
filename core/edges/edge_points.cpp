#include "core/edges/edge_points.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr double cube_m = 0.25;

std::uint64_t pack(std::int64_t x, std::int64_t y, std::int64_t z) {
  const auto part = [](std::int64_t v) { return static_cast<std::uint64_t>(v + (1 << 20)) & 0x1FFFFF; };
  return part(x) << 42 | part(y) << 21 | part(z);
}

std::int64_t cube_of(double x) { return static_cast<std::int64_t>(std::floor(x / cube_m)); }

std::uint64_t key_of(const Vector3d& p) { return pack(cube_of(p.x()), cube_of(p.y()), cube_of(p.z())); }

template <class Visit>
void for_each_cube(const Vector3d& p, double radius_m, const Visit& visit) {
  for (std::int64_t x = cube_of(p.x() - radius_m); x <= cube_of(p.x() + radius_m); ++x) {
    for (std::int64_t y = cube_of(p.y() - radius_m); y <= cube_of(p.y() + radius_m); ++y) {
      for (std::int64_t z = cube_of(p.z() - radius_m); z <= cube_of(p.z() + radius_m); ++z) visit(pack(x, y, z));
    }
  }
}

// The number of a key in a list that is ascending; `missing` where it is none of them.
class KeyTable {
 public:
  static constexpr std::uint32_t missing = ~std::uint32_t{0};

  explicit KeyTable(const std::vector<std::uint64_t>& keys) : keys_(keys) {
    std::size_t size = 64;
    while (size < 2 * keys.size()) size *= 2;
    table_.assign(size, missing);
    for (std::size_t k = 0; k < keys.size(); ++k) table_[slot(keys[k])] = static_cast<std::uint32_t>(k);
  }
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const { return table_[slot(key)]; }

 private:
  // Where the key is, or would be: open addressing.
  [[nodiscard]] std::size_t slot(std::uint64_t key) const {
    std::size_t at = static_cast<std::size_t>((key * 0x9E3779B97F4A7C15ULL) >> 20) & (table_.size() - 1);
    while (table_[at] != missing && keys_[table_[at]] != key) at = (at + 1) & (table_.size() - 1);
    return at;
  }
  const std::vector<std::uint64_t>& keys_;
  std::vector<std::uint32_t> table_;
};

std::vector<std::uint64_t> wanted_cubes(const std::vector<EdgePiece>& pieces, double reach_m) {
  std::vector<std::uint64_t> keys;
  for (const EdgePiece& piece : pieces) {
    for_each_cube(piece.middle, reach_m, [&](std::uint64_t key) { keys.push_back(key); });
  }
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
  return keys;
}

}  // namespace

double EdgePoint::variance_along(const Vector3d& n, const NoiseModel& noise) const {
  return noise.variance_along(static_cast<double>(range_m) * ray_G.cast<double>(), n);
}

EdgePoints::EdgePoints(const std::vector<EdgePiece>& pieces, const std::vector<PatchCells>& patches,
                       const RigState& state, const std::vector<char>& use, double reach_m) {
  keys_ = wanted_cubes(pieces, reach_m);
  const KeyTable cubes(keys_);
  std::vector<std::vector<std::pair<std::uint32_t, EdgePoint>>> of_patch(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use.empty() && !use[k]) continue;
      const SE3 T = state.T_G_sensor(patches[k].stop, patches[k].lidar);
      for (const Point& point : patches[k].thinned) {
        const Vector3d p(point.x, point.y, point.z);
        const Vector3d g = T * p;
        const std::uint32_t cube = cubes.find(key_of(g));
        if (cube == KeyTable::missing) continue;
        const double range = p.norm();
        of_patch[k].push_back({cube,
                               {g.cast<float>(), (T.R * p / range).cast<float>(), static_cast<float>(range),
                                static_cast<std::uint16_t>(patches[k].lidar)}});
      }
    }
  });
  starts_.assign(keys_.size() + 1, 0);
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

void EdgePoints::around(const Vector3d& p, double radius_m, std::vector<const EdgePoint*>& found) const {
  for_each_cube(p, radius_m, [&](std::uint64_t key) {
    const auto it = std::lower_bound(keys_.begin(), keys_.end(), key);
    if (it == keys_.end() || *it != key) return;
    const auto k = static_cast<std::size_t>(it - keys_.begin());
    for (std::size_t i = starts_[k]; i < starts_[k + 1]; ++i) found.push_back(&points_[i]);
  });
}

}  // namespace rigcal
