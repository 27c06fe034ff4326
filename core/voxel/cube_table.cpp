#include "core/voxel/cube_table.h"

#include <algorithm>

#include "core/base/packed_cube.h"
#include "core/base/wide.h"

namespace rigcal {
namespace {

constexpr double thin_size_m = 0.02;

// For all of the block, however many points it has.
RIGCAL_WIDE void place(double size_m, const PointBlock& block, PlacedInCubes& at) {
  const double inverse = 1.0 / size_m;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const float* const point = block.at[axis].data();
    std::int32_t* const cube = at.cube[axis].data();
    double* const off = at.off[axis].data();
    for (std::size_t i = 0; i < cell_block; ++i) {
      const double p = point[i];
      const std::int32_t whole = small_floor_of(p * inverse);
      cube[i] = whole;
      off[i] = p - (static_cast<double>(whole) + 0.5) * size_m;
    }
  }
  const std::int32_t* const x = at.cube[0].data();
  const std::int32_t* const y = at.cube[1].data();
  const std::int32_t* const z = at.cube[2].data();
  for (std::size_t i = 0; i < cell_block; ++i) at.key[i] = packed_cube(x[i], y[i], z[i]);
}

// Up to 10 small cubes a side fit the 1024 bits (cells of 0.2 m); larger cells have larger ones, which only thins more.
RIGCAL_WIDE void place_in_cube(double size_m, PlacedInCubes& at) {
  const double scale = std::min(1.0 / thin_size_m, 10.0 / size_m);
  const double half = 0.5 * size_m;
  const auto small = [&](double d) { return std::min(9, std::max(0, static_cast<std::int32_t>((d + half) * scale))); };
  for (std::size_t i = 0; i < cell_block; ++i)
    at.thin_cube[i] = (small(at.off[0][i]) * 10 + small(at.off[1][i])) * 10 + small(at.off[2][i]);
}

}  // namespace

void CubeTable::begin(const CellOptions& options) {
  options_ = options;
  numbers_.clear();
  places_.clear();
  sums_.clear();
  thin_bits_.clear();
  thinned_.clear();
}

// That of the i-th point of the block.
void CubeTable::add_cube(std::size_t i) {
  places_.push_back({placed_.cube[0][i], placed_.cube[1][i], placed_.cube[2][i]});
  sums_.emplace_back();
  if (options_.keep_thinned) thin_bits_.emplace_back().fill(0);
}

void CubeTable::add(const PointBlock& block) {
  EachOfBlock<std::uint32_t> number;
  place(options_.size_m, block, placed_);
  if (options_.keep_thinned) place_in_cube(options_.size_m, placed_);
  for (std::size_t i = 0; i < block.count; ++i) numbers_.fetch(placed_.key[i]);
  for (std::size_t i = 0; i < block.count; ++i) {
    if (i > 0 && placed_.key[i] == placed_.key[i - 1]) {
      number[i] = number[i - 1];
    } else {
      const KeyNumbers::Met met = numbers_.meet(placed_.key[i]);
      if (met.first) add_cube(i);
      number[i] = met.number;
    }
    __builtin_prefetch(&sums_[number[i]], 1);
    __builtin_prefetch(&sums_[number[i]].zz, 1);
    if (options_.keep_thinned) __builtin_prefetch(&thin_word(number[i], placed_.thin_cube[i]), 1);
  }
  for (std::size_t i = 0; i < block.count; ++i)
    sums_[number[i]].add(placed_.off[0][i], placed_.off[1][i], placed_.off[2][i]);
  if (!options_.keep_thinned) return;
  for (std::size_t i = 0; i < block.count; ++i) {
    const std::int32_t cube = placed_.thin_cube[i];
    std::uint64_t& word = thin_word(number[i], cube);
    const std::uint64_t mask = std::uint64_t{1} << (cube % 64);
    if ((word & mask) != 0) continue;
    word |= mask;
    thinned_.push_back(*block.point[i]);
  }
}

void CubeTable::finish(PatchCells& out) {
  const auto middle = [&](std::int32_t at) { return (static_cast<double>(at) + 0.5) * options_.size_m; };
  out.cells.reserve(sums_.size());
  for (std::size_t i = 0; i < sums_.size(); ++i)
    out.cells.push_back(sums_[i].about({middle(places_[i].x), middle(places_[i].y), middle(places_[i].z)}));
  // Copied, so that what is given away has its size, and what it grew in is used again.
  out.thinned = thinned_;
  begin(options_);
}

}  // namespace rigcal
