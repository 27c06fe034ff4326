#include "core/voxel/cells.h"

#include <algorithm>

#include "core/voxel/cube_table.h"
#include "core/voxel/ray_table.h"

namespace rigcal {

struct CellBuilder::Tables {
  int lidar = 0;
  int stop = 0;
  float max_range_m = 0.0F;
  std::uint64_t points = 0;
  std::uint64_t too_far = 0;
  PointBlock block{};
  CubeTable cubes;
  RayTable rays;

  // At most `cell_block` points.
  void add(std::span<const Point> given) {
    block.count = 0;
    for (const Point& p : given) {
      block.point[block.count] = &p;
      block.at[0][block.count] = p.x;
      block.at[1][block.count] = p.y;
      block.at[2][block.count] = p.z;
      block.count += p.x * p.x + p.y * p.y + p.z * p.z < max_range_m * max_range_m ? 1 : 0;
    }
    // What is left from the block before, or is too far, would be no number that fits.
    for (EachOfBlock<float>& coordinate : block.at)
      std::fill(coordinate.begin() + static_cast<std::ptrdiff_t>(block.count), coordinate.end(), 0.0F);
    cubes.add(block);
    rays.add(block);
    points += block.count;
    too_far += given.size() - block.count;
  }
};

CellBuilder::CellBuilder(int lidar, int stop, const CellOptions& options) : tables_(std::make_unique<Tables>()) {
  begin(lidar, stop, options);
}
CellBuilder::~CellBuilder() = default;
CellBuilder::CellBuilder(CellBuilder&&) noexcept = default;
CellBuilder& CellBuilder::operator=(CellBuilder&&) noexcept = default;

void CellBuilder::begin(int lidar, int stop, const CellOptions& options) {
  tables_->lidar = lidar;
  tables_->stop = stop;
  tables_->max_range_m = static_cast<float>(options.max_range_m);
  tables_->points = 0;
  tables_->too_far = 0;
  tables_->cubes.begin(options);
  tables_->rays.begin(options);
}

void CellBuilder::add(std::span<const Point> points) {
  while (!points.empty()) {
    const std::size_t count = std::min(cell_block, points.size());
    tables_->add(points.first(count));
    points = points.subspan(count);
  }
}

PatchCells CellBuilder::finish() {
  PatchCells out;
  out.lidar = tables_->lidar;
  out.stop = tables_->stop;
  out.points = tables_->points;
  out.too_far = tables_->too_far;
  tables_->cubes.finish(out);
  tables_->rays.finish(out);
  tables_->points = 0;
  tables_->too_far = 0;
  return out;
}

}  // namespace rigcal
