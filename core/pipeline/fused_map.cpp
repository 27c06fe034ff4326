#include "core/pipeline/fused_map.h"

#include <array>
#include <cmath>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr std::uint64_t none = ~std::uint64_t{0};
constexpr std::size_t shards = 64;

std::uint64_t cube_of(const MapPoint& p, double inverse) {
  const auto part = [&](float x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x * inverse)) + (1 << 20)) & 0x1FFFFF;
  };
  return part(p.x) << 42 | part(p.y) << 21 | part(p.z);
}

std::uint64_t mixed(std::uint64_t key) {
  key *= 0x9E3779B97F4A7C15ULL;
  return key ^ key >> 29;
}

// Marks the first point of every cube among those that fall in one shard.
void mark_first(const std::vector<std::uint64_t>& keys, const std::vector<std::uint32_t>& members,
                std::vector<char>& keep) {
  std::size_t size = 64;
  while (size < 2 * members.size()) size *= 2;
  std::vector<std::uint64_t> table(size, none);
  for (const std::uint32_t i : members) {
    std::size_t at = static_cast<std::size_t>(mixed(keys[i]) >> 8) & (size - 1);
    while (table[at] != none && table[at] != keys[i]) at = (at + 1) & (size - 1);
    if (table[at] == keys[i]) continue;
    table[at] = keys[i];
    keep[i] = 1;
  }
}

}  // namespace

std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                               const std::vector<char>& use, const std::vector<int>& sensor_of, double size_m) {
  std::vector<std::size_t> start(patches.size() + 1, 0);
  for (std::size_t k = 0; k < patches.size(); ++k) start[k + 1] = start[k] + (use[k] ? patches[k].thinned.size() : 0);
  std::vector<MapPoint> map(start.back());
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use[k]) continue;
      const PatchCells& patch = patches[k];
      const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
      const auto sensor = static_cast<std::uint8_t>(sensor_of[static_cast<std::size_t>(patch.lidar)]);
      for (std::size_t i = 0; i < patch.thinned.size(); ++i) {
        const Point& p = patch.thinned[i];
        const Eigen::Vector3f g = (T * Vector3d(p.x, p.y, p.z)).cast<float>();
        map[start[k] + i] = {g.x(), g.y(), g.z(), p.reflectivity, sensor};
      }
    }
  });
  if (size_m <= 0.0) return map;
  std::vector<std::uint64_t> keys(map.size());
  parallel_for(map.size(), 65536, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) keys[i] = cube_of(map[i], 1.0 / size_m);
  });
  std::array<std::vector<std::uint32_t>, shards> members;
  for (std::uint32_t i = 0; i < keys.size(); ++i) members[mixed(keys[i]) >> 58].push_back(i);
  std::vector<char> keep(map.size(), 0);
  parallel_for(shards, 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) mark_first(keys, members[s], keep);
  });
  std::size_t count = 0;
  for (std::size_t i = 0; i < map.size(); ++i) {
    if (keep[i]) map[count++] = map[i];
  }
  map.resize(count);
  return map;
}

}  // namespace rigcal
