#include "core/voxel/patch_of_points.h"

#include "core/base/parallel.h"
#include "core/base/spare_pool.h"

namespace rigcal {

PatchCells patch_of_points(std::span<const Vector3d> points, int lidar, int stop, const CellOptions& options) {
  CellBuilder builder(lidar, stop, options);
  std::vector<Point> narrow;
  narrow.reserve(points.size());
  for (const Vector3d& p : points) {
    Point& point = narrow.emplace_back();
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
  }
  builder.add(narrow);
  return builder.finish();
}

std::vector<PatchCells> cells_of_patches(std::span<const Patch> patches, const CellOptions& options) {
  std::vector<PatchCells> cells(patches.size());
  SparePool<CellBuilder> builders;
  parallel_for(cells.size(), 1, [&](std::size_t begin, std::size_t end) {
    std::unique_ptr<CellBuilder> builder = builders.take();
    for (std::size_t k = begin; k < end; ++k) {
      builder->begin(patches[k].sensor, patches[k].stop, options);
      builder->add(patches[k].points);
      cells[k] = builder->finish();
    }
    builders.give_back(std::move(builder));
  });
  return cells;
}

}  // namespace rigcal
