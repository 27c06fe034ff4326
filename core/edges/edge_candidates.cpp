#include "core/edges/edge_candidates.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/parallel.h"
#include "core/base/radix_sort.h"
#include "core/edges/cube_grid.h"
#include "core/voxel/cube_key.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {
namespace {

constexpr double min_leaf_m = 0.25;  // Smaller leaves are strips along an edge: their normals are not sure.

// What edges ask of a leaf.
struct Leaf {
  Vector3d center;
  WorldPlane plane;
  double
      reach_m;  // how far beyond its own middle it may be met: leaves know the size of their voxel, not their outline
};

std::vector<Leaf> unmerged(const std::vector<PlaneFeature>& features) {
  std::vector<Leaf> leaves;
  for (const PlaneFeature& f : features) {
    if (f.merged || f.size_m < min_leaf_m) continue;
    leaves.push_back({f.center_G, {f.normal_G, f.normal_G.dot(f.center_G)}, 0.9 * f.size_m + 0.15});
  }
  return leaves;
}

// For each cube the leaves whose balls touch it: who may be near a place is one look.
class LeafLists {
 public:
  // `radius_m(leaf)` of the balls.
  template <class Radius>
  LeafLists(const std::vector<Leaf>& leaves, const Radius& radius_m) {
    std::vector<std::pair<std::uint32_t, std::uint32_t>> entries;  // cube, leaf
    for (std::uint32_t i = 0; i < leaves.size(); ++i) {
      for_each_cube(leaves[i].center, radius_m(leaves[i]),
                    [&](std::uint64_t key) { entries.emplace_back(cubes_.meet(key).number, i); });
    }
    starts_.assign(std::size_t{cubes_.size()} + 1, 0);
    for (const auto& [cube, leaf] : entries) ++starts_[cube + 1];
    for (std::size_t c = 1; c < starts_.size(); ++c) starts_[c] += starts_[c - 1];
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    members_.resize(entries.size());
    for (const auto& [cube, leaf] : entries) members_[next[cube]++] = leaf;
  }

  // In ascending order.
  [[nodiscard]] std::span<const std::uint32_t> at(const Vector3d& p) const {
    const std::uint32_t cube = cubes_.find(cube_number(cube_place(p, per_m)));
    if (cube == KeyNumbers::unknown) return {};
    return std::span(members_).subspan(starts_[cube], starts_[cube + 1] - starts_[cube]);
  }

 private:
  static constexpr double per_m = 1.0;  // cubes

  template <class Visit>
  static void for_each_cube(const Vector3d& center, double radius_m, const Visit& visit) {
    const CubePlace low = cube_place(center - Vector3d::Constant(radius_m), per_m);
    const CubePlace high = cube_place(center + Vector3d::Constant(radius_m), per_m);
    // From the center to the interval of a cube along one axis.
    const auto off = [](double c, std::int64_t at) {
      const double begin = static_cast<double>(at) / per_m;
      return std::max({0.0, begin - c, c - begin - 1.0 / per_m});
    };
    for (std::int64_t x = low.x; x <= high.x; ++x) {
      const double x2 = std::pow(off(center.x(), x), 2);
      for (std::int64_t y = low.y; y <= high.y; ++y) {
        const double xy2 = x2 + std::pow(off(center.y(), y), 2);
        for (std::int64_t z = low.z; z <= high.z; ++z) {
          if (xy2 + std::pow(off(center.z(), z), 2) <= radius_m * radius_m) visit(cube_number({x, y, z}));
        }
      }
    }
  }

  KeyNumbers cubes_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> members_;
};

struct Interval {
  double low;
  double high;
};

// Of the line's parameter inside a ball.
Interval inside(const Line3& line, const Vector3d& center, double radius) {
  const double along = line.direction.dot(center - line.p);
  const double across2 = (center - line.p).squaredNorm() - along * along;
  const double half2 = radius * radius - across2;
  if (half2 <= 0.0) return {1.0, -1.0};
  return {along - std::sqrt(half2), along + std::sqrt(half2)};
}

// One sign for a direction and its opposite.
Vector3d one_sided(const Vector3d& direction) {
  for (const double c : {direction.x(), direction.y(), direction.z()}) {
    if (std::abs(c) > 0.3) return c > 0.0 ? direction : Vector3d(-direction);
  }
  return direction;
}

// What two pieces of one edge share: place to 10 cm and direction to some degrees, as one number.
std::uint64_t key_of(const Vector3d& middle, const Vector3d& direction) {
  const auto part = [](double x, double size, int bits) {
    const std::int64_t half = std::int64_t{1} << (bits - 1);
    return static_cast<std::uint64_t>(std::lround(x / size) + half) & ((std::uint64_t{1} << bits) - 1);
  };
  constexpr int place_bits = 17;
  constexpr int turn_bits = 4;
  std::uint64_t key = 0;
  for (int axis = 0; axis < 3; ++axis) key = key << place_bits | part(middle[axis], 0.1, place_bits);
  for (int axis = 0; axis < 3; ++axis) key = key << turn_bits | part(direction[axis], 0.25, turn_bits);
  return key;
}

// A piece before it is known whether another pair of leaves gives it, too.
struct Candidate {
  std::uint64_t key = 0;
  Vector3d middle;
  Vector3d direction;
  std::uint32_t a = 0;  // of the leaves
  std::uint32_t b = 0;
};

// Where in a list of candidates.
struct KeyedIndex {
  std::uint64_t key = 0;
  std::uint32_t index = 0;
};

// Of each two leaves that may meet the larger one (or the later one of two as large) is in the list of the smaller
// one's cube.
void find_pairs(const std::vector<Leaf>& leaves, const LeafLists& twice_as_far, std::uint32_t i, double max_dot,
                std::vector<Candidate>& found) {
  const Leaf& a = leaves[i];
  for (const std::uint32_t j : twice_as_far.at(a.center)) {
    const Leaf& b = leaves[j];
    if (b.reach_m < a.reach_m || (b.reach_m == a.reach_m && j <= i)) continue;
    const double reach_m = a.reach_m + b.reach_m;
    if ((a.center - b.center).squaredNorm() > reach_m * reach_m) continue;
    if (std::abs(a.plane.n.dot(b.plane.n)) > max_dot) continue;
    const Line3 line = intersect(a.plane, b.plane, 0.5 * (a.center + b.center));
    const Interval of_a = inside(line, a.center, a.reach_m);
    const Interval of_b = inside(line, b.center, b.reach_m);
    // Pieces lie on a raster along the line, so that pairs of leaves on one edge name the same ones.
    const double origin = line.direction.dot(line.p);
    const double low = origin + std::max(of_a.low, of_b.low);
    const double high = origin + std::min(of_a.high, of_b.high);
    for (double at = std::floor(low / edge_piece_m) * edge_piece_m; low < high && at < high; at += edge_piece_m) {
      const Vector3d middle = line.p + (at + 0.5 * edge_piece_m - origin) * line.direction;
      found.push_back({key_of(middle, line.direction), middle, line.direction, i, j});
    }
  }
}

std::vector<Candidate> all_candidates(const std::vector<Leaf>& leaves) {
  constexpr std::size_t grain = 128;
  const LeafLists lists(leaves, [](const Leaf& leaf) { return 2.0 * leaf.reach_m; });
  const double max_dot = std::cos(least_edge_angle_rad);
  std::vector<std::vector<Candidate>> parts((leaves.size() + grain - 1) / grain);
  parallel_for(leaves.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      find_pairs(leaves, lists, static_cast<std::uint32_t>(i), max_dot, parts[begin / grain]);
    }
  });
  std::vector<Candidate> all;
  for (const std::vector<Candidate>& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

}  // namespace

Line3 intersect(const WorldPlane& a, const WorldPlane& b, const Vector3d& near) {
  Line3 line;
  line.direction = one_sided(a.n.cross(b.n).normalized());
  Matrix3d M;
  M << a.n.transpose(), b.n.transpose(), line.direction.transpose();
  line.p = M.partialPivLu().solve(Vector3d(a.d, b.d, line.direction.dot(near)));
  return line;
}

std::vector<EdgePiece> edge_candidates(const std::vector<PlaneFeature>& features) {
  const std::vector<Leaf> leaves = unmerged(features);
  const std::vector<Candidate> candidates = all_candidates(leaves);
  std::vector<KeyedIndex> order(candidates.size());
  for (std::uint32_t i = 0; i < candidates.size(); ++i) order[i] = {candidates[i].key, i};
  radix_sort(order);
  // The first of each key is kept.
  const auto end = std::unique(order.begin(), order.end(), [](const auto& x, const auto& y) { return x.key == y.key; });
  order.erase(end, order.end());
  const double max_dot = std::cos(least_edge_angle_rad);
  const auto near_m = [&](const Leaf& leaf) { return leaf.reach_m + edge_piece_m; };
  const LeafLists near(leaves, near_m);
  std::vector<EdgePiece> pieces(order.size());
  parallel_for(pieces.size(), 256, [&](std::size_t first, std::size_t last) {
    for (std::size_t k = first; k < last; ++k) {
      const Candidate& from = candidates[order[k].index];
      EdgePiece& piece = pieces[k];
      piece = {from.middle, from.direction, leaves[from.a].plane, leaves[from.b].plane, {}};
      for (const std::uint32_t i : near.at(piece.middle)) {
        const Leaf& other = leaves[i];
        if ((other.center - piece.middle).squaredNorm() >= near_m(other) * near_m(other)) continue;
        const auto apart = [&](const WorldPlane& face) { return std::abs(other.plane.n.dot(face.n)) < max_dot; };
        if (apart(piece.a) && apart(piece.b)) piece.others.push_back(other.plane);
      }
    }
  });
  return pieces;
}

}  // namespace rigcal
