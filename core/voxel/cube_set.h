#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/voxel/key_numbers.h"

namespace rigcal {

/// Which cubes of the world have had a point: a bit each, eight by eight by eight of them together, since points that
/// follow each other lie close together. Blocks are dealt out to shards, and a thread takes a shard at a time, so that
/// the answer is the same with any number of them.
class CubeSet {
 public:
  /// `size_m`: edge of a cube. Those within 2^23 edges of the origin are told apart.
  explicit CubeSet(double size_m) : per_m_(1.0 / size_m) {}

  /// Sets `is_first[i]` to 1 where no point was in the cube of `points[i]` (world frame, m) before, in this call or in
  /// earlier ones, else to 0. Both are as long.
  void add(std::span<const Eigen::Vector3f> points, std::span<char> is_first);

 private:
  static constexpr std::size_t shards = 64;
  struct Place {
    std::uint64_t block = 0;
    std::uint32_t point = 0;
    std::uint32_t cube = 0;  // within the block
  };
  struct Shard {
    KeyNumbers numbers;  // of blocks
    std::vector<std::array<std::uint64_t, 8>> bits;
  };
  using Starts = std::array<std::uint32_t, shards + 1>;

  void deal_out(std::span<const Eigen::Vector3f> points);
  void mark(std::size_t shard, std::span<char> is_first);

  double per_m_;
  std::array<Shard, shards> shards_;
  std::vector<Place> places_;   ///< Of the points of this call, sorted by shard, chunk by chunk.
  std::vector<Starts> starts_;  ///< Of the shards in `places_`, for each chunk.
};

}  // namespace rigcal
