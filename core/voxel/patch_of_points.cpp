#include "core/voxel/patch_of_points.h"

#include <vector>

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

}  // namespace rigcal
