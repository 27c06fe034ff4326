#include "core/voxel/plane_map.h"

#include <algorithm>
#include <cmath>

#include "core/base/floor_of.h"
#include "core/base/parallel.h"
#include "core/base/parallel_sort.h"
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

// Morton code of the smallest voxel that holds p: the codes of a larger voxel are one contiguous range.
std::uint64_t morton(const Vector3d& p, double size) {
  const auto index = [&](double x) { return static_cast<std::uint64_t>(floor_of(x / size) + (1 << 20)); };
  return spread(index(p.x())) << 2 | spread(index(p.y())) << 1 | spread(index(p.z()));
}

void move_cells(const PatchCells& patch, std::uint32_t index, const SE3& T_G_sensor, const SE3& T_grid_G, double size,
                WorldCell* out) {
  const Matrix3d& R = T_G_sensor.R;
  for (std::uint32_t i = 0; i < patch.cells.size(); ++i) {
    const Cell& cell = patch.cells[i];
    WorldCell& w = out[i];
    w.patch = index;
    w.cell = i;
    w.N = cell.N;
    w.mean = T_G_sensor * cell.mean;
    w.key = morton(T_grid_G * w.mean, size);
    const Matrix3d S = R * cell.scatter_matrix() * R.transpose();
    w.scatter << S(0, 0), S(0, 1), S(0, 2), S(1, 1), S(1, 2), S(2, 2);
  }
}

std::vector<WorldCell> sorted_world_cells(const std::vector<PatchCells>& patches, const RigState& state,
                                          const SE3& T_grid_G, double size, const std::vector<char>& use) {
  std::vector<std::size_t> start(patches.size() + 1, 0);
  for (std::size_t i = 0; i < patches.size(); ++i) {
    start[i + 1] = start[i] + (use.empty() || use[i] ? patches[i].cells.size() : 0);
  }
  std::vector<WorldCell> moved(start.back());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (start[i + 1] == start[i]) continue;
      move_cells(patches[i], static_cast<std::uint32_t>(i), state.T_G_sensor(patches[i].stop, patches[i].lidar),
                 T_grid_G, size, moved.data() + start[i]);
    }
  });
  // Sorted by key, within a key by patch and cell: sort small handles, then gather.
  std::vector<std::pair<std::uint64_t, std::uint32_t>> handles(moved.size());
  for (std::uint32_t i = 0; i < handles.size(); ++i) handles[i] = {moved[i].key, i};
  parallel_sort(handles);
  std::vector<WorldCell> sorted(moved.size());
  parallel_for(handles.size(), 4096, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) sorted[i] = moved[handles[i].second];
  });
  return sorted;
}

// One root voxel, split from the top.
class RootSplitter {
 public:
  RootSplitter(const GateContext& context, PlaneMap& out) : context_(context), out_(out) {}

  // `cells` share all bits of their keys above 3 * level; level 0 is the smallest voxel.
  void split(std::span<WorldCell> cells, int level, double size) {
    const PlaneMapOptions& o = context_.options;
    const CellTotal total = total_of(cells);
    if (total.N < o.min_points || (o.min_patches > 1 && one_patch(cells))) {
      ++out_.counts.leaves_dropped;
      return;
    }
    if (may_be_plane(total)) {
      // Below this level the order of the keys is not needed any more unless it is split: sort a copy by patch.
      by_patch_.assign(cells.begin(), cells.end());
      std::stable_sort(by_patch_.begin(), by_patch_.end(),
                       [](const WorldCell& a, const WorldCell& b) { return a.patch < b.patch; });
      PlaneFeature feature;
      std::size_t kept = 0;
      if (gate_plane(by_patch_, total, context_, feature, kept) == PlaneVerdict::plane) {
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
  std::vector<WorldCell> by_patch_;
};

}  // namespace

PlaneMap build_plane_map(const std::vector<PatchCells>& patches, const RigState& state,
                         const std::vector<NoiseModel>& noise, const SE3& T_grid_G, const PlaneMapOptions& options,
                         const std::vector<char>& use) {
  const int levels = std::max(0, static_cast<int>(std::lround(std::log2(options.root_size_m / options.min_size_m))));
  std::vector<WorldCell> cells = sorted_world_cells(patches, state, T_grid_G, options.min_size_m, use);
  std::vector<std::size_t> roots;
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (i == 0 || cells[i].key >> (3 * levels) != cells[i - 1].key >> (3 * levels)) roots.push_back(i);
  }
  roots.push_back(cells.size());
  const GateContext context{patches, state, noise, options};
  constexpr std::size_t grain = 8;
  const std::size_t count = roots.size() - 1;
  std::vector<PlaneMap> parts((count + grain - 1) / grain);
  parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
    RootSplitter splitter(context, parts[begin / grain]);
    for (std::size_t r = begin; r < end; ++r) {
      splitter.split(std::span(cells).subspan(roots[r], roots[r + 1] - roots[r]), levels, options.root_size_m);
    }
  });
  PlaneMap map;
  map.counts.cells = cells.size();
  for (PlaneMap& part : parts) {
    std::move(part.features.begin(), part.features.end(), std::back_inserter(map.features));
    map.counts.cells_used += part.counts.cells_used;
    map.counts.cells_gated += part.counts.cells_gated;
    map.counts.leaves_dropped += part.counts.leaves_dropped;
  }
  return map;
}

}  // namespace rigcal
