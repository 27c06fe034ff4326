#include "core/edges/edge_candidates.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <tuple>

namespace rigcal {
namespace {

// How far beyond its own middle a leaf may be met; leaves know the size of their voxel, not their outline.
double reach_of(const PlaneFeature& leaf) { return 0.9 * leaf.size_m + 0.15; }

// Leaves by the cube that holds their middle.
class LeafGrid {
 public:
  LeafGrid(const std::vector<PlaneFeature>& leaves, double size_m) : size_m_(size_m) {
    for (std::size_t i = 0; i < leaves.size(); ++i) {
      if (!leaves[i].merged) entries_.emplace_back(cube(leaves[i].center_G), i);
    }
    std::sort(entries_.begin(), entries_.end());
  }

  template <class Visit>
  void around(const Vector3d& p, const Visit& visit) const {
    const auto [x, y, z] = cube(p);
    for (std::int64_t dx = -1; dx <= 1; ++dx) {
      for (std::int64_t dy = -1; dy <= 1; ++dy) {
        const Entry first{{x + dx, y + dy, z - 1}, 0};
        for (auto it = std::lower_bound(entries_.begin(), entries_.end(), first); it != entries_.end(); ++it) {
          const auto& [ix, iy, iz] = it->first;
          if (ix != x + dx || iy != y + dy || iz > z + 1) break;
          visit(it->second);
        }
      }
    }
  }

 private:
  using Cube = std::tuple<std::int64_t, std::int64_t, std::int64_t>;
  using Entry = std::pair<Cube, std::size_t>;

  [[nodiscard]] Cube cube(const Vector3d& p) const {
    const auto part = [&](double x) { return static_cast<std::int64_t>(std::floor(x / size_m_)); };
    return {part(p.x()), part(p.y()), part(p.z())};
  }

  double size_m_;
  std::vector<Entry> entries_;
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

WorldPlane plane_of(const PlaneFeature& leaf) { return {leaf.normal_G, leaf.normal_G.dot(leaf.center_G)}; }

// One sign for a direction and its opposite.
Vector3d one_sided(const Vector3d& direction) {
  for (const double c : {direction.x(), direction.y(), direction.z()}) {
    if (std::abs(c) > 0.3) return c > 0.0 ? direction : Vector3d(-direction);
  }
  return direction;
}

// What two pieces of one edge share: place to 10 cm and direction to some degrees.
using PieceKey = std::array<std::int64_t, 6>;

PieceKey key_of(const EdgePiece& piece) {
  const auto part = [](double x, double size) { return static_cast<std::int64_t>(std::lround(x / size)); };
  const Vector3d& m = piece.middle;
  const Vector3d& d = piece.direction;
  return {part(m.x(), 0.1),  part(m.y(), 0.1),  part(m.z(), 0.1),
          part(d.x(), 0.25), part(d.y(), 0.25), part(d.z(), 0.25)};
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

std::vector<EdgePiece> edge_candidates(const std::vector<PlaneFeature>& leaves, const LidarEdgeOptions& options) {
  double largest = 0.25;
  for (const PlaneFeature& leaf : leaves) {
    if (!leaf.merged) largest = std::max(largest, leaf.size_m);
  }
  const LeafGrid grid(leaves, 2.0 * (0.9 * largest + 0.15));
  const double max_dot = std::cos(options.min_angle_rad);
  std::vector<std::pair<PieceKey, EdgePiece>> pieces;
  for (std::size_t i = 0; i < leaves.size(); ++i) {
    if (leaves[i].merged) continue;
    const WorldPlane a = plane_of(leaves[i]);
    grid.around(leaves[i].center_G, [&](std::size_t j) {
      if (j <= i || std::abs(a.n.dot(leaves[j].normal_G)) > max_dot) return;
      const WorldPlane b = plane_of(leaves[j]);
      const Line3 line = intersect(a, b, 0.5 * (leaves[i].center_G + leaves[j].center_G));
      const Interval of_a = inside(line, leaves[i].center_G, reach_of(leaves[i]));
      const Interval of_b = inside(line, leaves[j].center_G, reach_of(leaves[j]));
      // Pieces lie on a raster along the line, so that pairs of leaves on one edge name the same ones.
      const double origin = line.direction.dot(line.p);
      const double low = origin + std::max(of_a.low, of_b.low);
      const double high = origin + std::min(of_a.high, of_b.high);
      if (low >= high) return;
      const double step = options.piece_m;
      for (double at = std::floor(low / step) * step; at < high; at += step) {
        const EdgePiece piece{line.p + (at + 0.5 * step - origin) * line.direction, line.direction, a, b, {}};
        pieces.emplace_back(key_of(piece), piece);
      }
    });
  }
  std::stable_sort(pieces.begin(), pieces.end(), [](const auto& x, const auto& y) { return x.first < y.first; });
  std::vector<EdgePiece> out;
  for (std::size_t k = 0; k < pieces.size(); ++k) {
    if (k == 0 || pieces[k].first != pieces[k - 1].first) out.push_back(pieces[k].second);
  }
  for (EdgePiece& piece : out) {
    grid.around(piece.middle, [&](std::size_t i) {
      const WorldPlane other = plane_of(leaves[i]);
      const bool near = (leaves[i].center_G - piece.middle).norm() < reach_of(leaves[i]) + options.piece_m;
      const auto apart = [&](const WorldPlane& face) { return std::abs(other.n.dot(face.n)) < max_dot; };
      if (near && apart(piece.a) && apart(piece.b)) piece.others.push_back(other);
    });
  }
  return out;
}

}  // namespace rigcal
