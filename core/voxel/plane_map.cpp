#include "core/voxel/plane_map.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "core/base/floor_of.h"
#include "core/base/parallel.h"
#include "core/base/radix_sort.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/plane_gate.h"

namespace rigcal {
namespace {

// Spreads the low 21 bits of v to every third bit.
std::uint64_t spread(std::uint64_t v) {
  v &= 0x1FFFFF;
  v = (v | v << 32) & 0x1F00000000FFFFULL;
  v = (v | v << 16) & 0x1F0000FF0000FFULL;
  v = (v | v << 8) & 0x100F00F00F00F00FULL;
  v = (v | v << 4) & 0x10C30C30C30C30C3ULL;
  v = (v | v << 2) & 0x1249249249249249ULL;
  return v;
}

// Of the index of a voxel at the grid's origin: a multiple of all voxels' sizes, and so that within a kilometre of the
// origin only the low bits of the codes differ.
constexpr std::int64_t origin_index = (1 << 20) + (1 << 11);

// Morton code of the smallest voxel that holds p: the codes of a larger voxel are one contiguous range.
std::uint64_t morton(const Vector3d& p, double per_m) {
  const auto index = [&](double x) { return static_cast<std::uint64_t>(floor_of(x * per_m) + origin_index); };
  return spread(index(p.x())) << 2 | spread(index(p.y())) << 1 | spread(index(p.z()));
}

// Which cell of which patch lies in a voxel.
struct Handle {
  std::uint64_t key = 0;
  std::uint32_t patch = 0;
  std::uint32_t cell = 0;
};

const std::vector<Cell>& cells_of(const PatchCells& patch, const PlaneMapOptions& options) {
  return options.by_cubes ? patch.cells : patch.pieces;
}

// R S R^T, both by their upper triangles.
Eigen::Matrix<double, 6, 1> turned(const Matrix3d& R, const Cell& cell) {
  const Matrix3d RS = R * cell.scatter_matrix();
  const auto element = [&](int i, int j) { return RS(i, 0) * R(j, 0) + RS(i, 1) * R(j, 1) + RS(i, 2) * R(j, 2); };
  Eigen::Matrix<double, 6, 1> out;
  out << element(0, 0), element(0, 1), element(0, 2), element(1, 1), element(1, 2), element(2, 2);
  return out;
}

// The cells that take part by voxel, within a voxel by patch and cell.
std::vector<Handle> sorted_handles(const std::vector<PatchCells>& patches, const std::vector<SE3>& T_G_sensor,
                                   const SE3& T_grid_G, const PlaneMapOptions& options, const std::vector<char>& use) {
  std::vector<std::size_t> start(patches.size() + 1, 0);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    start[i + 1] = start[i] + (use.empty() || use[i] ? cells_of(patches[i], options).size() : 0);
  }
  std::vector<Handle> handles(start.back());
  const double per_m = 1.0 / options.min_size_m;
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const SE3 T_grid_sensor = T_grid_G * T_G_sensor[i];
      const auto patch = static_cast<std::uint32_t>(i);
      if (start[i] == start[i + 1]) continue;
      Handle* next = &handles[start[i]];
      const std::vector<Cell>& cells = cells_of(patches[i], options);
      for (std::uint32_t number = 0; number < cells.size(); ++number)
        *next++ = {morton(T_grid_sensor * cells[number].mean, per_m), patch, number};
    }
  });
  radix_sort(handles);
  return handles;
}

// Moves those of one root voxel to the world: all at once they would not fit the caches.
void to_world(const std::vector<PatchCells>& patches, const std::vector<SE3>& T_G_sensor,
              const PlaneMapOptions& options, std::span<const Handle> handles, std::vector<WorldCell>& out) {
  constexpr std::size_t ahead = 12;  // of the cell at hand: they lie all over the memory
  out.clear();
  for (std::size_t i = 0; i < handles.size(); ++i) {
    if (i + ahead < handles.size()) {
      const Cell* next = &cells_of(patches[handles[i + ahead].patch], options)[handles[i + ahead].cell];
      __builtin_prefetch(next);
      __builtin_prefetch(next->scatter.data() + 5);
    }
    const Handle& handle = handles[i];
    const Cell& cell = cells_of(patches[handle.patch], options)[handle.cell];
    const SE3& T = T_G_sensor[handle.patch];
    out.push_back({handle.key, handle.patch, handle.cell, cell.N, T * cell.mean, turned(T.R, cell), cell.noise_share,
                   cell.noise_shift_per_m, cell.darkness});
  }
}

// One root voxel, split from the top.
class RootSplitter {
 public:
  RootSplitter(const GateContext& context, PlaneMap& out) : context_(context), out_(out) {}

  // `cells` share all bits of their keys above 3 * level; level 0 is the smallest voxel.
  void split(std::span<const WorldCell> cells, int level, double size) {
    const PlaneMapOptions& o = context_.options;
    const CellTotal total = total_of(cells);
    if (total.N < o.min_points || (o.min_patches > 1 && one_patch(cells))) {
      ++out_.counts.leaves_dropped;
      return;
    }
    if (may_be_plane(total)) {
      PlaneFeature feature;
      std::size_t kept = 0;
      if (gate_plane(cells, total, context_, feature, kept) == PlaneVerdict::plane) {
        feature.size_m = size;
        out_.features.push_back(std::move(feature));
        out_.counts.cells_used += kept;
        out_.counts.cells_gated += cells.size() - kept;
        return;
      }
    }
    if (level == 0) {
      ++out_.counts.leaves_dropped;
      return;
    }
    std::size_t begin = 0;
    while (begin < cells.size()) {
      const std::uint64_t child = cells[begin].key >> (3 * (level - 1));
      std::size_t end = begin + 1;
      while (end < cells.size() && cells[end].key >> (3 * (level - 1)) == child) ++end;
      split(cells.subspan(begin, end - begin), level - 1, 0.5 * size);
      begin = end;
    }
  }

 private:
  static bool one_patch(std::span<const WorldCell> cells) {
    for (const WorldCell& cell : cells) {
      if (cell.patch != cells[0].patch) return false;
    }
    return true;
  }

  bool may_be_plane(const CellTotal& total) const {
    const PlaneMapOptions& o = context_.options;
    const Vector3d l = symmetric_eigen_fast(total.scatter).values / total.N;
    return l[1] >= o.min_flatness * l[0] && l[2] <= o.max_elongation * l[1] &&
           l[0] <= o.max_thickness_m * o.max_thickness_m;
  }

  const GateContext& context_;
  PlaneMap& out_;
};

}  // namespace

PlaneMap build_plane_map(const std::vector<PatchCells>& patches, const RigState& state,
                         const std::vector<NoiseModel>& noise, const SE3& T_grid_G, const PlaneMapOptions& options,
                         const std::vector<char>& use) {
  const int levels = std::max(0, static_cast<int>(std::lround(std::log2(options.root_size_m / options.min_size_m))));
  std::vector<SE3> T_G_sensor;
  for (const PatchCells& patch : patches) T_G_sensor.push_back(state.T_G_sensor(patch.stop, patch.lidar));
  const std::vector<Handle> handles = sorted_handles(patches, T_G_sensor, T_grid_G, options, use);
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < handles.size(); ++i) {
    if (i == 0 || handles[i].key >> (3 * levels) != handles[i - 1].key >> (3 * levels)) roots.push_back(i);
  }
  roots.push_back(handles.size());
  const GateContext context{patches, state, noise, options};
  constexpr std::size_t grain = 8;
  const std::size_t count = roots.size() - 1;
  std::vector<PlaneMap> parts((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    RootSplitter splitter(context, parts[begin / grain]);
    thread_local std::vector<WorldCell> cells;
    for (std::size_t r = begin; r < end; ++r) {
      to_world(patches, T_G_sensor, options, std::span(handles).subspan(roots[r], roots[r + 1] - roots[r]), cells);
      splitter.split(cells, levels, options.root_size_m);
    }
  });
  PlaneMap map;
  map.counts.cells = handles.size();
  for (PlaneMap& part : parts) {
    std::move(part.features.begin(), part.features.end(), std::back_inserter(map.features));
    map.counts.cells_used += part.counts.cells_used;
    map.counts.cells_gated += part.counts.cells_gated;
    map.counts.leaves_dropped += part.counts.leaves_dropped;
  }
  return map;
}

}  // namespace rigcal
