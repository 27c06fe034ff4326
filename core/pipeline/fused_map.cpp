#include "core/pipeline/fused_map.h"

#include "core/voxel/cube_index.h"
#include "core/voxel/world_points.h"

namespace rigcal {
namespace {

void append(const PatchCells& patch, const std::vector<Eigen::Vector3f>& world, const std::vector<char>& keep,
            std::uint8_t sensor, std::vector<MapPoint>& map) {
  for (std::size_t i = 0; i < world.size(); ++i) {
    if (!keep[i]) continue;
    map.push_back({world[i].x(), world[i].y(), world[i].z(), patch.thinned[i].reflectivity, sensor});
  }
}

}  // namespace

// Patch by patch, so that the memory grows with the surface and not with the points.
std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                               const std::vector<char>& use, const std::vector<int>& sensor_of, double size_m) {
  std::vector<MapPoint> map;
  CubeIndex cubes(size_m);
  std::vector<char> keep;
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!use[k]) continue;
    const std::vector<Eigen::Vector3f> world = world_points(patches[k], state);
    keep.assign(world.size(), 1);
    if (size_m > 0.0) {
      cubes.add(world, [&](std::size_t, std::uint32_t, std::uint32_t i, bool first) { keep[i] = first ? 1 : 0; });
    }
    append(patches[k], world, keep, static_cast<std::uint8_t>(sensor_of[static_cast<std::size_t>(patches[k].lidar)]),
           map);
  }
  return map;
}

}  // namespace rigcal
