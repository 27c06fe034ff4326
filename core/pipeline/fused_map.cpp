#include "core/pipeline/fused_map.h"

#include "core/voxel/cube_set.h"
#include "core/voxel/world_points.h"

namespace rigcal {
namespace {

// Points whose cubes are looked up together: enough for all threads, and the memory still grows with the surface and
// not with the points.
constexpr std::size_t batch_points = 1 << 20;

}  // namespace

std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                               const std::vector<char>& use, const std::vector<int>& sensor_of, double size_m,
                               std::size_t every) {
  std::vector<MapPoint> map;
  // At most; what is not used of it is never touched, and growing would touch everything twice.
  std::size_t most = 0;
  for (std::size_t k = 0; k < patches.size(); ++k) most += use[k] ? (patches[k].thinned.size() + every - 1) / every : 0;
  map.reserve(most);
  CubeSet cubes(size_m);
  std::vector<Eigen::Vector3f> world;
  std::vector<char> keep;
  for (std::size_t begin = 0, end = 0; begin < patches.size(); begin = end) {
    world.clear();
    for (; end < patches.size() && world.size() < batch_points; ++end) {
      if (use[end]) append_world_points(patches[end], state, every, world);
    }
    keep.assign(world.size(), 1);
    if (size_m > 0.0) cubes.add(world, keep);
    std::size_t at = 0;
    for (std::size_t k = begin; k < end; ++k) {
      if (!use[k]) continue;
      const auto sensor = static_cast<std::uint8_t>(sensor_of[static_cast<std::size_t>(patches[k].lidar)]);
      for (std::size_t i = 0; i < patches[k].thinned.size(); i += every, ++at) {
        if (!keep[at]) continue;
        map.push_back({world[at].x(), world[at].y(), world[at].z(), patches[k].thinned[i].reflectivity, sensor});
      }
    }
  }
  return map;
}

std::vector<MapPoint> fuse_map_to_look_at(const std::vector<PatchCells>& patches, const RigState& state,
                                          const std::vector<char>& use, const std::vector<int>& sensor_of) {
  constexpr double size_m = 0.05;
  constexpr std::size_t every = 4;  // A surface has a point each 2 cm in every patch.
  return fuse_map(patches, state, use, sensor_of, size_m, every);
}

}  // namespace rigcal
