#include "core/voxel/ray_pieces.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

// What the wire's whole millimetres alone are off by, m^2.
constexpr double rounding_variance = 1e-6 / 12.0;
// Fewer points tell no corner from noise.
constexpr double least_points = 8.0;

// Some parts of a cell, a bit for each: all, or those of a quarter.
constexpr std::uint32_t all_parts = 0xFFFF;
constexpr std::uint32_t first_quarter = 0xF;

// Calls `f` with the number of each bit that is set.
template <class F>
void for_each_bit(std::uint32_t bits, const F& f) {
  for (; bits != 0; bits &= bits - 1) f(static_cast<std::size_t>(std::countr_zero(bits)));
}

// Points of some parts, those at the borders, and their darkness.
struct Total {
  CellSums sums;
  double at_near = 0.0;
  double at_far = 0.0;
  double dark = 0.0;
};

Total total_of(const CellParts& parts, std::uint32_t which) {
  Total all;
  for_each_bit(parts.hit & which, [&](std::size_t k) { all.sums += parts.sums[k]; });
  for_each_bit(which, [&](std::size_t k) {
    all.at_near += parts.at_near[k];
    all.at_far += parts.at_far[k];
    all.dark += parts.dark[k];
  });
  return all;
}

// Whether the parts lie in one plane as far as their own thickness tells: variance between them over variance within.
// Any plane goes through three: those few are told apart rather than judged.
bool is_flat(const CellSums& all, const CellParts& parts, std::uint32_t which) {
  const auto hit = static_cast<double>(std::popcount(parts.hit & which));
  if (hit < 2.0 || all.n < least_points) return true;
  if (hit < 4.0) return false;
  const Cell whole = all.about(Vector3d::Zero());
  const SymmetricEigen eigen = symmetric_eigen_fast(whole.scatter_matrix());
  const Vector3d u = eigen.vectors.col(0);
  double between = 0.0;
  // One of a few points may be the edge of another surface, as of a wall below a ceiling: it counts too.
  for_each_bit(parts.hit & which, [&](std::size_t k) {
    const CellSums& part = parts.sums[k];
    const double off = u.dot(Vector3d(part.vx, part.vy, part.vz)) / part.n - u.dot(whole.mean);
    between += part.n * off * off;
  });
  const double within = std::max(0.0, eigen.values[0] - between) / std::max(1.0, all.n - hit);
  // Of a flat cell this is one, give or take a share that falls with the parts. Many a flat one comes out above 1.3
  // times that share, which takes time and no accuracy; with more, corners stay whole (docs/decisions/026).
  const double most_bent = 1.0 + 1.3 * std::sqrt(2.0 / (hit - 3.0));
  return between / (hit - 3.0) <= most_bent * (within + rounding_variance);
}

// Two halves of a surface's noise are nearer together along a ray.
constexpr double most_apart_m = 0.1;
// Of the points of the cell that has fewer: where noise cuts a surface, both have points in nearly all directions;
// where the surface itself goes from one to the other, in few.
constexpr double least_common = 0.6;

// Whether what lies behind is the same surface, which a border between both cuts by its noise. Each about its own
// middle; that of the farther one is `depth_m` deeper.
bool is_cut_by_noise(const CellParts& near_parts, const CellParts& behind_parts, double depth_m) {
  const std::uint32_t both = near_parts.hit & behind_parts.hit;
  if (both == 0) return false;
  double n_near = 0.0;
  double n_behind = 0.0;
  for_each_bit(near_parts.hit, [&](std::size_t k) { n_near += near_parts.sums[k].n; });
  for_each_bit(behind_parts.hit, [&](std::size_t k) { n_behind += behind_parts.sums[k].n; });
  double common_near = 0.0;
  double common_behind = 0.0;
  double common = 0.0;
  double apart = 0.0;
  for_each_bit(both, [&](std::size_t k) {
    const CellSums& near = near_parts.sums[k];
    const CellSums& behind = behind_parts.sums[k];
    common_near += near.n;
    common_behind += behind.n;
    const double weight = std::min(near.n, behind.n);
    common += weight;
    apart += weight * (depth_m + behind.vx / behind.n - near.vx / near.n);
  });
  const bool same_directions =
      n_near < n_behind ? common_near >= least_common * n_near : common_behind >= least_common * n_behind;
  return same_directions && apart < most_apart_m * common;
}

// Makes two cells one, about the middle of the nearer; that of the other stands off it by `off`.
void join(const CellParts& behind, const Vector3d& off, CellParts& near) {
  for_each_bit(behind.hit, [&](std::size_t k) {
    CellSums moved = behind.sums[k];
    moved.move(off.x(), off.y(), off.z());
    near.of(k) += moved;
    near.dark[k] += behind.dark[k];
  });
  near.at_far = behind.at_far;
}

// Of each direction the points at a border are those of both sides.
void share_border(CellParts& near, CellParts& behind) {
  for (std::size_t k = 0; k < cell_sixteenths; ++k) {
    const double at_border = near.at_far[k] + behind.at_near[k];
    near.at_far[k] = at_border;
    behind.at_near[k] = at_border;
  }
}

}  // namespace

void PieceMaker::begin(const RayGrid& grid) {
  grid_ = &grid;
  has_cell_ = false;
  pieces_.clear();
}

void PieceMaker::take(std::uint64_t key) {
  if (next_->hit == 0) return;  // There are points of others at its borders, no more.
  const bool is_behind = has_cell_ && key == end_ && grid_->goes_on_behind(end_ - 1);
  if (is_behind) share_border(*cell_, *next_);
  if (!is_behind && grid_->goes_on_before(key)) next_->at_near.fill(0.0);
  if (is_behind && end_ == key_ + 1 && is_cut_by_noise(*cell_, *next_, grid_->size_m())) {
    join(*next_, grid_->middle_ahead(key) - grid_->middle_ahead(key_), *cell_);
    ++end_;
    return;
  }
  if (has_cell_) append_pieces(is_behind);
  std::swap(cell_, next_);
  has_cell_ = true;
  key_ = key;
  end_ = key + 1;
}

// One cell, or its quarters that are flat and the sixteenths of the others.
//
// Noise e along a ray moves a point across a border, or not. By Stein's lemma the sum of e over the points on one side
// is the variance of e times their density at the border, and that of e times depth is as much less than the variance
// for each point as the border is far from their mean.
//
// What leaves one side of a border for noise comes to the other: shifts of both sides are of the same points, so that
// all of a surface is moved nowhere. Where the other side has none of it none is moved.
void PieceMaker::append_pieces(bool has_behind) {
  CellParts& parts = *cell_;
  if (!has_behind && grid_->goes_on_behind(end_ - 1)) parts.at_far.fill(0.0);
  const int face = grid_->face_of(key_);
  const double size_m = grid_->size_m();
  const Vector3d ahead = grid_->middle_ahead(key_);
  const Vector3d middle = in_sensor(ahead, face);
  const double near_m = -0.5 * size_m;
  const double far_m = (static_cast<double>(end_ - key_) - 0.5) * size_m;
  const auto append = [&](const Total& part) {
    Cell& piece = pieces_.emplace_back(in_sensor(part.sums, face).about(middle));
    const double n = part.sums.n;
    const double depth = part.sums.vx / n;
    // Of its points, to each metre of depth; a border has two sides.
    const double per_m = 0.5 / (border_share * size_m * n);
    const double at_near = part.at_near * per_m;
    const double at_far = part.at_far * per_m;
    piece.noise_share = static_cast<float>(1.0 - at_near * (depth - near_m) - at_far * (far_m - depth));
    // To each metre along the ray it is less.
    piece.noise_shift_per_m =
        static_cast<float>((at_near - at_far) * (ahead.x() + depth) / std::max(1e-3, piece.mean.norm()));
    piece.darkness = static_cast<float>(part.dark / n);
  };
  const Total all = total_of(parts, all_parts);
  if (is_flat(all.sums, parts, all_parts)) {
    append(all);
    return;
  }
  for (std::uint32_t four = first_quarter; (four & all_parts) != 0; four <<= 4) {
    if ((parts.hit & four) == 0) continue;
    const Total quarter = total_of(parts, four);
    if (is_flat(quarter.sums, parts, four)) {
      append(quarter);
    } else {
      for_each_bit(parts.hit & four, [&](std::size_t k) {
        append({parts.sums[k], parts.at_near[k], parts.at_far[k], parts.dark[k]});
      });
    }
  }
}

const std::vector<Cell>& PieceMaker::finish() {
  if (has_cell_) append_pieces(false);
  has_cell_ = false;
  return pieces_;
}

}  // namespace rigcal
