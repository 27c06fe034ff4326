#include "core/start/surfels.h"

#include <algorithm>

#include "core/base/floor_of.h"
#include "core/base/packed_cube.h"
#include "core/base/parallel.h"
#include "core/base/radix_sort.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double min_flatness = 8.0;     // Middle over smallest eigenvalue.
constexpr double max_elongation = 25.0;  // Largest over middle.

// Which cell lies in a voxel.
struct Handle {
  std::uint64_t key = 0;
  std::uint32_t cell = 0;
};

std::uint64_t voxel_key(const Vector3d& p, double size) {
  return packed_cube(floor_of(p.x() / size), floor_of(p.y() / size), floor_of(p.z() / size));
}

enum class Shape { surfel, too_few, not_flat };

Shape shape_of(const std::vector<Cell>& cells, const Handle* first, const Handle* last, const SurfelOptions& o,
               Surfel& out) {
  out = {};
  for (const Handle* h = first; h != last; ++h) {
    out.N += cells[h->cell].N;
    out.mean += cells[h->cell].N * cells[h->cell].mean;
  }
  if (out.N < o.min_points) return Shape::too_few;
  out.mean /= out.N;
  Matrix3d S = Matrix3d::Zero();
  for (const Handle* h = first; h != last; ++h) {
    const Vector3d d = cells[h->cell].mean - out.mean;
    S += cells[h->cell].scatter_matrix() + cells[h->cell].N * d * d.transpose();
  }
  const SymmetricEigen eigen = symmetric_eigen_fast(S / out.N);
  const Vector3d& l = eigen.values;
  // A line of points (one ring of a spinning LiDAR) may become a surface with its neighbours.
  if (l[2] > max_elongation * l[1]) return Shape::too_few;
  if (l[1] < min_flatness * l[0] || l[0] > o.max_thickness_m * o.max_thickness_m) return Shape::not_flat;
  out.normal = eigen.vectors.col(0);
  if (out.normal.dot(out.mean) > 0.0) out.normal = -out.normal;
  out.variance = l[0] * out.N / (out.N - 3.0);
  return Shape::surfel;
}

}  // namespace

PatchSurfels extract_surfels(const PatchCells& patch, const SurfelOptions& options) {
  PatchSurfels out{patch.lidar, patch.stop, {}};
  std::vector<std::uint32_t> left(patch.cells.size());
  for (std::uint32_t i = 0; i < left.size(); ++i) left[i] = i;
  std::vector<Handle> handles;
  double size = options.size_m;
  for (int level = 0; level < 3; ++level, size *= 2.0) {
    handles.clear();
    for (const std::uint32_t i : left) handles.push_back({voxel_key(patch.cells[i].mean, size), i});
    radix_sort(handles);
    left.clear();
    const Handle* begin = handles.data();
    const Handle* const stop = handles.data() + handles.size();
    while (begin != stop) {
      const Handle* end = begin;
      while (end != stop && end->key == begin->key) ++end;
      Surfel surfel;
      const Shape shape = shape_of(patch.cells, begin, end, options, surfel);
      if (shape == Shape::surfel) out.surfels.push_back(surfel);
      if (shape == Shape::too_few) {
        for (const Handle* h = begin; h != end; ++h) left.push_back(h->cell);
      }
      begin = end;
    }
    // In the order of the cells, and so within each voxel.
    std::sort(left.begin(), left.end());
  }
  return out;
}

std::vector<PatchSurfels> extract_surfels(const std::vector<PatchCells>& patches, const SurfelOptions& options) {
  std::vector<PatchSurfels> out(patches.size());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) out[i] = extract_surfels(patches[i], options);
  });
  return out;
}

std::vector<PatchSurfels> thinned(const std::vector<PatchSurfels>& patches, std::size_t all, std::size_t least) {
  const std::size_t each = std::max(least, all / std::max<std::size_t>(1, patches.size()));
  std::vector<PatchSurfels> out;
  for (const PatchSurfels& patch : patches) {
    PatchSurfels& few = out.emplace_back(PatchSurfels{patch.lidar, patch.stop, {}});
    const std::size_t count = std::min(each, patch.surfels.size());
    for (std::size_t i = 0; i < count; ++i) few.surfels.push_back(patch.surfels[i * patch.surfels.size() / count]);
  }
  return out;
}

}  // namespace rigcal
