#include "core/voxel/world_points.h"

#include "core/base/parallel.h"

namespace rigcal {

std::vector<Eigen::Vector3f> world_points(const PatchCells& patch, const RigState& state) {
  const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
  std::vector<Eigen::Vector3f> world(patch.thinned.size());
  parallel_for(world.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point& p = patch.thinned[i];
      world[i] = (T * Vector3d(p.x, p.y, p.z)).cast<float>();
    }
  });
  return world;
}

}  // namespace rigcal
