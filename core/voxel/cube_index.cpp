#include "core/voxel/cube_index.h"

#include "core/base/floor_of.h"
#include "core/base/packed_cube.h"

namespace rigcal {
namespace {

constexpr std::size_t chunk = 16384;

}  // namespace

std::uint64_t cube_key(const Eigen::Vector3f& p, double per_m) {
  return packed_cube(floor_of(p.x() * per_m), floor_of(p.y() * per_m), floor_of(p.z() * per_m));
}

Eigen::Vector3d cube_corner(std::uint64_t key) {
  const auto part = [&](int axis) { return static_cast<double>(index_of_packed(key, axis)); };
  return {part(0), part(1), part(2)};
}

void CubeIndex::deal_out(std::span<const Eigen::Vector3f> points) {
  keys_.resize(points.size());
  order_.resize(points.size());
  starts_.resize((points.size() + chunk - 1) / chunk);
  parallel_for(points.size(), chunk, [&](std::size_t begin, std::size_t end) {
    std::array<std::uint32_t, shards> next{};
    for (std::size_t i = begin; i < end; ++i) {
      keys_[i] = cube_key(points[i], per_m_);
      ++next[KeyNumbers::shard(keys_[i])];
    }
    Starts& starts = starts_[begin / chunk];
    starts[0] = static_cast<std::uint32_t>(begin);
    for (std::size_t s = 0; s < shards; ++s) {
      starts[s + 1] = starts[s] + next[s];
      next[s] = starts[s];
    }
    for (std::size_t i = begin; i < end; ++i)
      order_[next[KeyNumbers::shard(keys_[i])]++] = static_cast<std::uint32_t>(i);
  });
}

}  // namespace rigcal
