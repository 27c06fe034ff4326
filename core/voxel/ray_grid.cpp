#include "core/voxel/ray_grid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>

#include "core/base/wide.h"

namespace rigcal {
namespace {

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

// How a key is put together.
struct KeyShape {
  std::int32_t middle;
  unsigned across_bits;
  unsigned deep_bits;
};

// The cell that many cells deep in the direction of a point of the block, where `across` of them fill 45 degrees.
[[gnu::always_inline]] inline PlaceInCell place_in_cell(const KeyShape shape, const PlacedOnRays& at, std::size_t i,
                                                        std::int32_t deep, double across) {
  const unsigned up_at = shape.deep_bits;
  const unsigned left_at = up_at + shape.across_bits;
  const unsigned face_at = left_at + shape.across_bits;
  const double scale = across / std::max(at.depth[i], 1e-9);
  const double inside = across * (1.0 - 1e-12);
  const double u = std::min(at.left[i] * scale, inside);
  const double v = std::min(at.up[i] * scale, inside);
  const std::int32_t iu = small_floor_of(u);
  const std::int32_t iv = small_floor_of(v);
  const auto su = static_cast<std::int32_t>(4.0 * (u - static_cast<double>(iu)));
  const auto sv = static_cast<std::int32_t>(4.0 * (v - static_cast<double>(iv)));
  return {static_cast<std::uint64_t>(at.face[i]) << face_at | static_cast<std::uint64_t>(iu + shape.middle) << left_at |
              static_cast<std::uint64_t>(iv + shape.middle) << up_at | static_cast<std::uint64_t>(deep),
          static_cast<std::uint32_t>((su & 2) << 2 | (sv & 2) << 1 | (su & 1) << 1 | (sv & 1))};
}

RIGCAL_WIDE void place_in_cells(const KeyShape shape, PlacedOnRays& at) {
  for (std::size_t i = 0; i < cell_block; ++i) {
    const PlaceInCell place = place_in_cell(shape, at, i, at.deep[i], at.across[i]);
    at.key[i] = place.key;
    at.sixteenth[i] = place.sixteenth;
  }
}

}  // namespace

RayGrid::RayGrid(double max_range_m, double size_m)
    : size_m_(size_m),
      across_(cells_across(max_range_m, size_m)),
      deep_bits_(static_cast<unsigned>(std::bit_width(across_.size()))) {
  for (std::size_t k = 0; k < across_.size(); ++k) {
    const bool before = k > 0 && across_[k - 1] != across_[k];
    is_at_change_.push_back(before || (k + 1 < across_.size() && across_[k + 1] != across_[k]) ? 1 : 0);
  }
  key_middle_ = static_cast<std::int32_t>(across_.back());
  across_bits_ = static_cast<unsigned>(std::bit_width(static_cast<unsigned>(2 * key_middle_)));
}

void RayGrid::place(const PointBlock& block, PlacedOnRays& at) const {
  place_by_depth(size_m_, block, at);
  for (std::size_t i = 0; i < cell_block; ++i) at.across[i] = across_[static_cast<std::size_t>(at.deep[i])];
  place_in_cells({key_middle_, across_bits_, deep_bits_}, at);
}

std::optional<OtherSide> RayGrid::other_side(const PlacedOnRays& at, std::size_t number, double border_m) const {
  const std::int32_t deep = at.deep[number];
  const double inside_m = at.depth[number] - deep * size_m_;
  const std::int32_t other = inside_m < border_m ? deep - 1 : inside_m > size_m_ - border_m ? deep + 1 : deep;
  if (other < 0) return std::nullopt;
  const double across = across_[static_cast<std::size_t>(other)];
  if (across == across_[static_cast<std::size_t>(deep)]) return std::nullopt;
  return OtherSide{place_in_cell({key_middle_, across_bits_, deep_bits_}, at, number, other, across), other < deep};
}

Vector3d RayGrid::middle_ahead(std::uint64_t key) const {
  const std::size_t deep = deep_of(key);
  const double middle = (static_cast<double>(deep) + 0.5) * size_m_;
  const double step = middle / across_[deep];
  const auto index = [&](unsigned shift) {
    const auto field = key >> shift & ((std::uint64_t{1} << across_bits_) - 1);
    return static_cast<double>(static_cast<std::int32_t>(field) - key_middle_);
  };
  return {middle, (index(deep_bits_ + across_bits_) + 0.5) * step, (index(deep_bits_) + 0.5) * step};
}

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

}  // namespace rigcal
