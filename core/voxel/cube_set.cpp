#include "core/voxel/cube_set.h"

#include "core/base/floor_of.h"
#include "core/base/packed_cube.h"
#include "core/base/parallel.h"

namespace rigcal {
namespace {

constexpr std::size_t chunk = 16384;
constexpr int edge_bits = 3;  // of a block's edge in cubes
constexpr std::int64_t in_block = (1 << edge_bits) - 1;

}  // namespace

void CubeSet::add(std::span<const Eigen::Vector3f> points, std::span<char> is_first) {
  deal_out(points);
  parallel_for(shards, 4, [&](std::size_t begin, std::size_t end) {
    for (std::size_t s = begin; s < end; ++s) mark(s, is_first);
  });
}

void CubeSet::deal_out(std::span<const Eigen::Vector3f> points) {
  places_.resize(points.size());
  starts_.resize((points.size() + chunk - 1) / chunk);
  parallel_for(points.size(), chunk, [&](std::size_t begin, std::size_t end) {
    thread_local std::vector<Place> in_order;
    in_order.clear();
    std::array<std::uint32_t, shards> next{};
    for (std::size_t i = begin; i < end; ++i) {
      const std::int64_t x = floor_of(points[i].x() * per_m_);
      const std::int64_t y = floor_of(points[i].y() * per_m_);
      const std::int64_t z = floor_of(points[i].z() * per_m_);
      const auto cube =
          static_cast<std::uint32_t>((((x & in_block) << edge_bits | (y & in_block)) << edge_bits) | (z & in_block));
      in_order.push_back(
          {packed_cube(x >> edge_bits, y >> edge_bits, z >> edge_bits), static_cast<std::uint32_t>(i), cube});
      ++next[KeyNumbers::shard(in_order.back().block)];
    }
    Starts& starts = starts_[begin / chunk];
    starts[0] = static_cast<std::uint32_t>(begin);
    for (std::size_t s = 0; s < shards; ++s) {
      starts[s + 1] = starts[s] + next[s];
      next[s] = starts[s];
    }
    for (const Place& place : in_order) places_[next[KeyNumbers::shard(place.block)]++] = place;
  });
}

// The points of one shard in their order.
void CubeSet::mark(std::size_t shard, std::span<char> is_first) {
  Shard& own = shards_[shard];
  for (const Starts& starts : starts_) {
    std::uint64_t block = 0;
    std::array<std::uint64_t, 8>* bits = nullptr;
    for (std::uint32_t k = starts[shard]; k < starts[shard + 1]; ++k) {
      const Place& place = places_[k];
      if (bits == nullptr || place.block != block) {
        const KeyNumbers::Met met = own.numbers.meet(place.block);
        if (met.first) own.bits.emplace_back().fill(0);
        bits = &own.bits[met.number];
        block = place.block;
      }
      std::uint64_t& word = (*bits)[place.cube / 64];
      const std::uint64_t mask = std::uint64_t{1} << (place.cube % 64);
      is_first[place.point] = (word & mask) == 0 ? 1 : 0;
      word |= mask;
    }
  }
}

}  // namespace rigcal
