#include "core/voxel/world_points.h"

#include "core/base/parallel.h"

namespace rigcal {

void append_world_points(const PatchCells& patch, const RigState& state, std::size_t every,
                         std::vector<Eigen::Vector3f>& world) {
  const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
  const std::size_t first = world.size();
  const std::size_t count = (patch.thinned.size() + every - 1) / every;
  world.resize(first + count);
  parallel_for(count, 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point& p = patch.thinned[i * every];
      world[first + i] = (T * Vector3d(p.x, p.y, p.z)).cast<float>();
    }
  });
}

}  // namespace rigcal
