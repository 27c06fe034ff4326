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

// The cubes that have a point, for one shard of all keys: open addressing.
class Cubes {
 public:
  /// True when the key is new.
  bool insert(std::uint64_t key) {
    if (2 * (used_ + 1) > table_.size()) grow();
    if (!place(key)) return false;
    ++used_;
    return true;
  }

 private:
  bool place(std::uint64_t key) {
    std::size_t at = static_cast<std::size_t>(mixed(key) >> 8) & (table_.size() - 1);
    while (table_[at] != none && table_[at] != key) at = (at + 1) & (table_.size() - 1);
    if (table_[at] == key) return false;
    table_[at] = key;
    return true;
  }

  void grow() {
    std::vector<std::uint64_t> before(2 * table_.size(), none);
    before.swap(table_);
    for (const std::uint64_t key : before) {
      if (key != none) place(key);
    }
  }

  std::vector<std::uint64_t> table_ = std::vector<std::uint64_t>(1 << 15, none);
  std::size_t used_ = 0;
};

std::vector<MapPoint> in_world(const PatchCells& patch, const RigState& state, std::uint8_t sensor) {
  const SE3 T = state.T_G_sensor(patch.stop, patch.lidar);
  std::vector<MapPoint> world(patch.thinned.size());
  parallel_for(world.size(), 16384, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      const Point& p = patch.thinned[i];
      const Eigen::Vector3f g = (T * Vector3d(p.x, p.y, p.z)).cast<float>();
      world[i] = {g.x(), g.y(), g.z(), p.reflectivity, sensor};
    }
  });
  return world;
}

// Says of the points of one patch after the other which are the first in their cubes. A thread takes a shard at a time,
// so that the answer is the same with any number of them.
class FirstInCubes {
 public:
  explicit FirstInCubes(double size_m) : inverse_(1.0 / size_m) {}

  const std::vector<char>& mark(const std::vector<MapPoint>& world) {
    keys_.resize(world.size());
    parallel_for(world.size(), 16384, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) keys_[i] = cube_of(world[i], inverse_);
    });
    for (std::vector<std::uint32_t>& shard : members_) shard.clear();
    for (std::uint32_t i = 0; i < keys_.size(); ++i) members_[mixed(keys_[i]) >> 58].push_back(i);
    first_.assign(world.size(), 0);
    parallel_for(shards, 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        for (const std::uint32_t i : members_[s]) first_[i] = cubes_[s].insert(keys_[i]) ? 1 : 0;
      }
    });
    return first_;
  }

 private:
  double inverse_;
  std::array<Cubes, shards> cubes_;
  std::array<std::vector<std::uint32_t>, shards> members_;
  std::vector<std::uint64_t> keys_;
  std::vector<char> first_;
};

}  // namespace

// Patch by patch, so that the memory grows with the surface and not with the points.
std::vector<MapPoint> fuse_map(const std::vector<PatchCells>& patches, const RigState& state,
                               const std::vector<char>& use, const std::vector<int>& sensor_of, double size_m) {
  std::vector<MapPoint> map;
  FirstInCubes first_in_cubes(size_m);
  for (std::size_t k = 0; k < patches.size(); ++k) {
    if (!use[k]) continue;
    const auto sensor = static_cast<std::uint8_t>(sensor_of[static_cast<std::size_t>(patches[k].lidar)]);
    const std::vector<MapPoint> world = in_world(patches[k], state, sensor);
    if (size_m <= 0.0) {
      map.insert(map.end(), world.begin(), world.end());
      continue;
    }
    const std::vector<char>& first = first_in_cubes.mark(world);
    for (std::size_t i = 0; i < world.size(); ++i) {
      if (first[i]) map.push_back(world[i]);
    }
  }
  return map;
}

}  // namespace rigcal
