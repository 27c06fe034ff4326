#include "core/start/shapes.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <tuple>

#include "core/geometry/symmetric_eigen.h"
#include "core/start/voxel_hash.h"

namespace rigcal {
namespace {

constexpr int neighbourhoods = 4;    // each twice as wide as the one before
constexpr double min_members = 6.0;  // cells in a neighbourhood, below which its form is chance
constexpr double line_ratio = 0.02;  // middle over largest eigenvalue below which it is a line: 1 : 7 in width

// The 27 voxels around a place, as steps of -1, 0 and 1 and one more: those first that lie nearest.
constexpr std::array<std::array<std::uint8_t, 3>, 27> inside_out = [] {
  std::array<std::array<std::uint8_t, 3>, 27> out{};
  std::size_t at = 0;
  for (int sides = 0; sides <= 3; ++sides) {
    for (unsigned i = 0; i < 27; ++i) {
      const std::array<std::uint8_t, 3> step{static_cast<std::uint8_t>(i / 9), static_cast<std::uint8_t>(i / 3 % 3),
                                             static_cast<std::uint8_t>(i % 3)};
      if ((step[0] != 1) + (step[1] != 1) + (step[2] != 1) == sides) out[at++] = step;
    }
  }
  return out;
}();

template <class F>
void for_each_neighbour(const Voxel& v, const F& f) {
  for (std::int64_t dx = -1; dx <= 1; ++dx)
    for (std::int64_t dy = -1; dy <= 1; ++dy)
      for (std::int64_t dz = -1; dz <= 1; ++dz) f(Voxel{v.x + dx, v.y + dy, v.z + dz});
}

// Sums over the cells of a voxel, each cell counted once: a near surface has more points, not more shape.
struct Sums {
  Voxel voxel{0, 0, 0};
  double n = 0.0;
  Vector3d v = Vector3d::Zero();
  Matrix3d P = Matrix3d::Zero();

  void add(const Cell& cell) {
    n += 1.0;
    v += cell.mean;
    P += cell.scatter_matrix() / cell.N + cell.mean * cell.mean.transpose();
  }
  void add(const Sums& other) {
    n += other.n;
    v += other.v;
    P += other.P;
  }
};

// Voxels of one size with their sums, found by place.
class SumGrid {
 public:
  SumGrid(const std::vector<Cell>& cells, double size) : size_(size) {
    std::size_t slots = 1024;
    while (slots < 2 * cells.size()) slots *= 2;
    slots_.assign(slots, 0);
    for (const Cell& cell : cells) {
      const Voxel v = voxel_of(cell.mean, size);
      std::uint32_t& slot = slots_[slot_of(v)];
      if (slot == 0) {
        sums_.push_back({v});
        slot = static_cast<std::uint32_t>(sums_.size());
      }
      sums_[slot - 1].add(cell);
    }
  }

  [[nodiscard]] const std::vector<Sums>& sums() const { return sums_; }

  // Total of the voxel of p and the 26 around it.
  [[nodiscard]] Sums around(const Vector3d& p) const {
    Sums total;
    for_each_neighbour(voxel_of(p, size_), [&](const Voxel& v) {
      const std::uint32_t slot = slots_[slot_of(v)];
      if (slot != 0) total.add(sums_[slot - 1]);
    });
    return total;
  }

 private:
  [[nodiscard]] std::size_t slot_of(const Voxel& v) const {
    const std::size_t mask = slots_.size() - 1;
    std::size_t at = hash_of(v) & mask;
    while (slots_[at] != 0) {
      const Voxel& w = sums_[slots_[at] - 1].voxel;
      if (w.x == v.x && w.y == v.y && w.z == v.z) break;
      at = (at + 1) & mask;
    }
    return at;
  }

  double size_;
  std::vector<std::uint32_t> slots_;  // index + 1 into sums_, 0: empty
  std::vector<Sums> sums_;
};

}  // namespace

std::vector<LocalShape> extract_shapes(const PatchCells& patch, double size_m) {
  std::vector<SumGrid> grids;
  for (int k = 0; k < neighbourhoods; ++k) grids.emplace_back(patch.cells, std::ldexp(size_m, k));
  std::vector<LocalShape> out;
  for (const Sums& place : grids[0].sums()) {
    LocalShape shape;
    shape.mean = place.v / place.n;
    // A neighbourhood as wide as a third of its distance holds more than one thing.
    const double widest = 0.5 + 0.15 * shape.mean.norm();
    bool has_shape = false;
    for (int k = 0; k < neighbourhoods; ++k) {
      if (k > 0 && std::ldexp(1.5 * size_m, k) > widest) break;
      const Sums around = grids[static_cast<std::size_t>(k)].around(shape.mean);
      if (around.n < min_members) continue;
      const Vector3d mean = around.v / around.n;
      shape.covariance = around.P / around.n - mean * mean.transpose();
      has_shape = true;
      const Vector3d l = symmetric_eigen_fast(shape.covariance).values;
      if (l[1] > line_ratio * l[2]) break;
    }
    if (has_shape) out.push_back(shape);
  }
  return out;
}

std::vector<LocalShape> without_repetitions(const std::vector<LocalShape>& shapes, double size_m) {
  std::set<std::tuple<std::int64_t, std::int64_t, std::int64_t>> seen;
  std::vector<LocalShape> out;
  for (const LocalShape& s : shapes) {
    const Voxel v = voxel_of(s.mean, size_m);
    if (seen.emplace(v.x, v.y, v.z).second) out.push_back(s);
  }
  return out;
}

ShapeIndex::ShapeIndex(const std::vector<LocalShape>& shapes, double reach_m) : reach_m_(reach_m) {
  std::size_t size = 1024;
  while (size < 2 * shapes.size()) size *= 2;
  mask_ = size - 1;
  bucket_start_.assign(size + 1, 0);
  std::vector<std::size_t> buckets;
  for (const LocalShape& s : shapes) {
    const Voxel v = voxel_of(s.mean, reach_m);
    buckets.push_back(hash_of(v) & mask_);
    ++bucket_start_[buckets.back() + 1];
  }
  for (std::size_t i = 1; i < bucket_start_.size(); ++i) bucket_start_[i] += bucket_start_[i - 1];
  shapes_.resize(shapes.size());
  means_.resize(shapes.size());
  std::vector<std::uint32_t> fill(bucket_start_.begin(), bucket_start_.end() - 1);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const std::uint32_t at = fill[buckets[i]]++;
    shapes_[at] = shapes[i];
    means_[at] = shapes[i].mean;
  }
}

int ShapeIndex::nearest(const Vector3d& p) const {
  const Voxel own = voxel_of(p, reach_m_);
  // How far voxels before and behind are at least, squared, along each axis.
  std::array<std::array<double, 3>, 3> off{};
  for (std::size_t k = 0; k < 3; ++k) {
    const auto axis = static_cast<Eigen::Index>(k);
    const double within = p[axis] - reach_m_ * static_cast<double>(std::array{own.x, own.y, own.z}[k]);
    off[k] = {within * within, 0.0, (reach_m_ - within) * (reach_m_ - within)};
  }
  int best = -1;
  double best_distance = reach_m_ * reach_m_;
  for (const std::array<std::uint8_t, 3>& step : inside_out) {
    if (off[0][step[0]] + off[1][step[1]] + off[2][step[2]] >= best_distance) continue;
    const std::size_t b = hash_of({own.x + step[0] - 1, own.y + step[1] - 1, own.z + step[2] - 1}) & mask_;
    for (std::uint32_t i = bucket_start_[b]; i < bucket_start_[b + 1]; ++i) {
      const double distance = (means_[i] - p).squaredNorm();
      if (distance < best_distance) {
        best_distance = distance;
        best = static_cast<int>(i);
      }
    }
  }
  return best;
}

}  // namespace rigcal
