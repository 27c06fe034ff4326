#include "core/voxel/ray_table.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "core/base/radix_sort.h"
#include "core/base/wide.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr std::uint32_t no_sums = ~std::uint32_t{0};

// What the wire's whole millimetres alone are off by, m^2.
constexpr double rounding_variance = 1e-6 / 12.0;
// Fewer points tell no corner from noise.
constexpr double least_points = 8.0;

// Of a cell's depth: how near to a border points count as at it. It is less than noise is wide, 2 cm, so that what lies
// there is what noise moves to and fro.
constexpr double border_share = 1.0 / 16.0;

// Parts of one cell, all about its middle; without points where nothing was hit.
using Parts = std::span<const PartSums>;

PartSums total_of(Parts parts) {
  PartSums all;
  for (const PartSums& part : parts) all += part;
  return all;
}

// Whether the parts lie in one plane as far as their own thickness tells: variance between them over variance within.
// Any plane goes through three: those few are told apart rather than judged.
bool is_flat(const CellSums& all, Parts parts) {
  const auto hit = static_cast<double>(
      std::count_if(parts.begin(), parts.end(), [](const PartSums& part) { return part.sums.n > 0.0; }));
  if (hit < 2.0 || all.n < least_points) return true;
  if (hit < 4.0) return false;
  const Cell whole = all.about(Vector3d::Zero());
  const SymmetricEigen eigen = symmetric_eigen_fast(whole.scatter_matrix());
  const Vector3d u = eigen.vectors.col(0);
  double between = 0.0;
  for (const PartSums& each : parts) {
    const CellSums& part = each.sums;
    // One of a few points may be the edge of another surface, as of a wall below a ceiling: it counts too.
    if (part.n == 0.0) continue;
    const double off = u.dot(Vector3d(part.vx, part.vy, part.vz)) / part.n - u.dot(whole.mean);
    between += part.n * off * off;
  }
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
bool is_cut_by_noise(Parts near_parts, Parts behind_parts, double depth_m) {
  double n_near = 0.0;
  double n_behind = 0.0;
  double common_near = 0.0;
  double common_behind = 0.0;
  double common = 0.0;
  double apart = 0.0;
  for (std::size_t i = 0; i < near_parts.size(); ++i) {
    const CellSums& near = near_parts[i].sums;
    const CellSums& behind = behind_parts[i].sums;
    n_near += near.n;
    n_behind += behind.n;
    if (near.n == 0.0 || behind.n == 0.0) continue;
    common_near += near.n;
    common_behind += behind.n;
    const double weight = std::min(near.n, behind.n);
    common += weight;
    apart += weight * (depth_m + behind.vx / behind.n - near.vx / near.n);
  }
  const bool same_directions =
      n_near < n_behind ? common_near >= least_common * n_near : common_behind >= least_common * n_behind;
  return common > 0.0 && same_directions && apart < most_apart_m * common;
}

// Of what looks left and up in a key: both ways from the middle.
constexpr std::int32_t key_middle = 1 << 19;

// How many cells side by side fill 45 degrees, by how many cells deep they lie: what is one number over a range of
// depths that doubles in two steps. Two cells more than points can lie deep: rounding may place one a cell deeper, and
// its border is with the next.
std::vector<double> cells_across(double max_range_m, double size_m) {
  std::vector<double> across;
  const auto most = static_cast<std::size_t>(max_range_m / size_m) + 3;
  double end = 1.0;
  for (std::size_t k = 0; k < most; ++k) {
    while (static_cast<double>(k) >= std::round(end)) end *= std::numbers::sqrt2;
    across.push_back(std::round(end));
  }
  return across;
}

// For all of the block, however many points it has. Along its greatest coordinate a point lies ahead; left and up are
// the two that follow.
RIGCAL_WIDE void place_by_depth(double size_m, const PointBlock& block, PlacedOnRays& at) {
  const double inverse = 1.0 / size_m;
  const float* const xs = block.at[0].data();
  const float* const ys = block.at[1].data();
  const float* const zs = block.at[2].data();
  for (std::size_t i = 0; i < cell_block; ++i) {
    const double x = xs[i];
    const double y = ys[i];
    const double z = zs[i];
    const double ax = std::abs(x);
    const double ay = std::abs(y);
    const double az = std::abs(z);
    const double of_yz = az > ay ? az : ay;
    const double depth = of_yz > ax ? of_yz : ax;
    // x before y before z where two are the same.
    double ahead = ay == depth ? y : z;
    double left = ay == depth ? z : x;
    double up = ay == depth ? x : y;
    std::int32_t face = ay == depth ? 2 : 4;
    ahead = ax == depth ? x : ahead;
    left = ax == depth ? y : left;
    up = ax == depth ? z : up;
    face = ax == depth ? 0 : face;
    at.depth[i] = depth;
    at.left[i] = left;
    at.up[i] = up;
    at.deep[i] = static_cast<std::int32_t>(depth * inverse);
    at.face[i] = face + (ahead < 0.0 ? 1 : 0);
  }
}

// Where the cells of their depth are `across` as many.
RIGCAL_WIDE void place_in_cells(double size_m, PlacedOnRays& at) {
  for (std::size_t i = 0; i < cell_block; ++i) {
    const double depth = at.depth[i];
    const double across = at.across[i];
    const double deep = at.deep[i];
    const double scale = across / std::max(depth, 1e-9);
    const double inside = across * (1.0 - 1e-12);
    const double u = std::min(at.left[i] * scale, inside);
    const double v = std::min(at.up[i] * scale, inside);
    const std::int32_t iu = small_floor_of(u);
    const std::int32_t iv = small_floor_of(v);
    const double fu = u - static_cast<double>(iu);
    const double fv = v - static_cast<double>(iv);
    const double middle = (deep + 0.5) * size_m;
    const double step = middle / across;
    at.off_ahead[i] = depth - middle;
    at.off_left[i] = at.left[i] - (static_cast<double>(iu) + 0.5) * step;
    at.off_up[i] = at.up[i] - (static_cast<double>(iv) + 0.5) * step;
    at.key[i] = static_cast<std::uint64_t>(at.face[i]) << 60 | static_cast<std::uint64_t>(iu + key_middle) << 40 |
                static_cast<std::uint64_t>(iv + key_middle) << 20 | static_cast<std::uint64_t>(at.deep[i]);
    at.sixteenth[i] = static_cast<std::int32_t>(4.0 * fu) * 4 + static_cast<std::int32_t>(4.0 * fv);
  }
}

// Which of the six ways a cell's points lie ahead: along x, y or z, and against them.
int face_of(std::uint64_t key) { return static_cast<int>(key >> 60); }

// How many cells deep it lies.
std::size_t deep_of(std::uint64_t key) { return key & 0xFFFFF; }

// The middle of a cell by its key: how far ahead, left and up.
Vector3d middle_ahead(std::uint64_t key, double size_m, const std::vector<double>& across_at) {
  const std::size_t deep = deep_of(key);
  const double middle = (static_cast<double>(deep) + 0.5) * size_m;
  const double step = middle / across_at[deep];
  const auto index = [&](int shift) {
    return static_cast<double>(static_cast<std::int32_t>(key >> shift & 0xFFFFF) - key_middle);
  };
  return {middle, (index(40) + 0.5) * step, (index(20) + 0.5) * step};
}

// From ahead, left and up to x, y and z.
Vector3d in_sensor(const Vector3d& p, int face) {
  const double ahead = face % 2 == 1 ? -p.x() : p.x();
  switch (face / 2) {
    case 0:
      return {ahead, p.y(), p.z()};
    case 1:
      return {p.z(), ahead, p.y()};
    default:
      return {p.y(), p.z(), ahead};
  }
}

CellSums in_sensor(CellSums s, int face) {
  if (face % 2 == 1) {
    s.vx = -s.vx;
    s.xy = -s.xy;
    s.xz = -s.xz;
  }
  switch (face / 2) {
    case 0:
      return s;
    case 1:
      return {s.n, s.vz, s.vx, s.vy, s.zz, s.xz, s.yz, s.xx, s.xy, s.yy};
    default:
      return {s.n, s.vy, s.vz, s.vx, s.yy, s.yz, s.xy, s.zz, s.xz, s.xx};
  }
}

}  // namespace

void RayTable::begin(const CellOptions& options) {
  options_ = options;
  across_ = cells_across(options.max_range_m, options.size_m);
  numbers_.clear();
  keys_.clear();
  sums_of_.clear();
  sums_.clear();
  pieces_.clear();
}

void RayTable::add(const PointBlock& block) {
  EachOfBlock<std::uint32_t> cell;
  EachOfBlock<std::uint32_t> part;
  place_by_depth(options_.size_m, block, placed_);
  for (std::size_t i = 0; i < cell_block; ++i) placed_.across[i] = across_[static_cast<std::size_t>(placed_.deep[i])];
  place_in_cells(options_.size_m, placed_);
  for (std::size_t i = 0; i < block.count; ++i) numbers_.fetch(placed_.key[i]);
  for (std::size_t i = 0; i < block.count; ++i) {
    if (i > 0 && placed_.key[i] == placed_.key[i - 1]) {
      cell[i] = cell[i - 1];
    } else {
      const KeyNumbers::Met met = numbers_.meet(placed_.key[i]);
      if (met.first) {
        keys_.push_back(placed_.key[i]);
        sums_of_.emplace_back().fill(no_sums);
      }
      cell[i] = met.number;
    }
    __builtin_prefetch(&sums_of_[cell[i]][static_cast<std::size_t>(placed_.sixteenth[i])], 1);
  }
  for (std::size_t i = 0; i < block.count; ++i) {
    std::uint32_t& number = sums_of_[cell[i]][static_cast<std::size_t>(placed_.sixteenth[i])];
    if (number == no_sums) {
      number = static_cast<std::uint32_t>(sums_.size());
      sums_.emplace_back();
    }
    part[i] = number;
    __builtin_prefetch(&sums_[number], 1);
    __builtin_prefetch(&sums_[number].at_far, 1);
  }
  const double border = (0.5 - border_share) * options_.size_m;
  for (std::size_t i = 0; i < block.count; ++i) {
    PartSums& to = sums_[part[i]];
    const double ahead = placed_.off_ahead[i];
    to.sums.add(ahead, placed_.off_left[i], placed_.off_up[i]);
    to.at_near += ahead < -border ? 1.0 : 0.0;
    to.at_far += ahead > border ? 1.0 : 0.0;
  }
}

// Of a cell that comes soon: its sums lie all over the memory.
void RayTable::prefetch(std::uint32_t cell) const {
  for (const std::uint32_t number : sums_of_[cell]) {
    if (number == no_sums) continue;
    __builtin_prefetch(&sums_[number]);
    __builtin_prefetch(&sums_[number].at_far);
  }
}

// Quarter by quarter: four by four directions. Of what lies at a border it is one side of two, unless the cells on the
// other side are others: then the density is that of this side.
void RayTable::load(std::uint32_t cell, CellParts& out) const {
  const std::size_t deep = deep_of(keys_[cell]);
  const double near_share = deep > 0 && across_[deep - 1] != across_[deep] ? 1.0 : 0.5;
  const double far_share = across_[deep + 1] != across_[deep] ? 1.0 : 0.5;
  for (std::size_t k = 0; k < cell_sixteenths; ++k) {
    const std::size_t quarter = k / 4;
    const std::uint32_t number = sums_of_[cell][(quarter / 2) * 8 + (quarter % 2) * 2 + (k % 4 / 2) * 4 + k % 2];
    out[k] = number == no_sums ? PartSums{} : sums_[number];
    out[k].at_near *= near_share;
    out[k].at_far *= far_share;
  }
}

// The cell behind that of this key, if it is the first of the next ones: both then share what lies at their border.
bool RayTable::load_behind(std::span<const Keyed> next, std::uint64_t key, CellParts& parts, CellParts& behind) const {
  if (next.empty() || next.front().key != key + 1) return false;
  load(next.front().number, behind);
  const std::size_t deep = deep_of(key);
  if (across_[deep + 1] != across_[deep]) return true;
  for (std::size_t k = 0; k < cell_sixteenths; ++k) {
    const double at_border = parts[k].at_far + behind[k].at_near;
    parts[k].at_far = at_border;
    behind[k].at_near = at_border;
  }
  return true;
}

// One cell, or its quarters that are flat and the sixteenths of the others; `end`: the key behind it, which is a cell
// more where two are one.
//
// Noise e along a ray moves a point across a border, or not. By Stein's lemma the sum of e over the points on one side
// is the variance of e times their density at the border, and that of e times depth is as much less than the variance
// for each point as the border is far from their mean.
void RayTable::append_pieces(std::uint64_t key, std::uint64_t end, const CellParts& parts) {
  const int face = face_of(key);
  const Vector3d ahead = middle_ahead(key, options_.size_m, across_);
  const Vector3d middle = in_sensor(ahead, face);
  const double near_m = -0.5 * options_.size_m;
  const double far_m = (static_cast<double>(end - key) - 0.5) * options_.size_m;
  const auto append = [&](const PartSums& part) {
    Cell& piece = pieces_.emplace_back(in_sensor(part.sums, face).about(middle));
    const double n = part.sums.n;
    const double depth = part.sums.vx / n;
    // Of its points, to each metre of depth; a few points have no more at a border than there are of them.
    const double per_m = 1.0 / (border_share * options_.size_m * n);
    const double at_near = std::min(part.at_near, n) * per_m;
    const double at_far = std::min(part.at_far, n) * per_m;
    piece.noise_share = 1.0 - at_near * (depth - near_m) - at_far * (far_m - depth);
    // To each metre along the ray it is less.
    piece.noise_shift_per_m = (at_near - at_far) * (ahead.x() + depth) / std::max(1e-3, piece.mean.norm());
  };
  const PartSums all = total_of(parts);
  if (is_flat(all.sums, parts)) {
    append(all);
    return;
  }
  for (std::size_t first = 0; first < cell_sixteenths; first += 4) {
    const Parts four = Parts(parts).subspan(first, 4);
    const PartSums quarter = total_of(four);
    if (quarter.sums.n == 0.0) continue;
    if (is_flat(quarter.sums, four)) {
      append(quarter);
      continue;
    }
    for (const PartSums& part : four) {
      if (part.sums.n > 0.0) append(part);
    }
  }
}

void RayTable::finish(PatchCells& out) {
  std::vector<Keyed> order(keys_.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = {keys_[i], i};
  radix_sort(order);
  constexpr std::size_t soon = 4;
  constexpr std::size_t later = 12;
  CellParts near;
  CellParts behind;
  CellParts farther;
  bool is_loaded = false;
  for (std::size_t i = 0; i < order.size(); ++i) {
    if (i + later < order.size()) __builtin_prefetch(&sums_of_[order[i + later].number]);
    if (i + soon < order.size()) prefetch(order[i + soon].number);
    const std::uint64_t key = order[i].key;
    if (!is_loaded) load(order[i].number, near);
    is_loaded = load_behind(std::span(order).subspan(i + 1), key, near, behind);
    std::uint64_t end = key + 1;
    if (is_loaded && is_cut_by_noise(near, behind, options_.size_m)) {
      ++end;
      ++i;
      is_loaded = load_behind(std::span(order).subspan(i + 1), key + 1, behind, farther);
      const Vector3d off =
          middle_ahead(key + 1, options_.size_m, across_) - middle_ahead(key, options_.size_m, across_);
      for (std::size_t k = 0; k < cell_sixteenths; ++k) {
        behind[k].sums.move(off.x(), off.y(), off.z());
        near[k].sums += behind[k].sums;
        near[k].at_far = behind[k].at_far;
      }
      if (is_loaded) std::swap(behind, farther);
    }
    append_pieces(key, end, near);
    if (is_loaded) std::swap(near, behind);
  }
  // Copied, so that what is given away has its size, and what it grew in is used again.
  out.pieces = pieces_;
  begin(options_);
}

}  // namespace rigcal
