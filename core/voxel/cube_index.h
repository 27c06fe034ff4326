#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"
#include "core/voxel/key_numbers.h"

namespace rigcal {

/// The cube of edge 1 / `per_m` that holds p, as one number; cubes within 2^20 edges of the origin have different ones.
[[nodiscard]] std::uint64_t cube_key(const Eigen::Vector3f& p, double per_m);

/// The corner of a key's cube at which all coordinates are least, in edges.
[[nodiscard]] Eigen::Vector3d cube_corner(std::uint64_t key);

/// Tells points by the cube of the world that they lie in. The cubes are dealt out to shards, and a thread takes a
/// shard at a time, so that the answer is the same with any number of them.
class CubeIndex {
 public:
  static constexpr std::size_t shards = 64;

  explicit CubeIndex(double size_m) : per_m_(1.0 / size_m) {}

  /// Calls `visit(shard, cube, i, first)` for every point, `cube` its cube's number within the shard; `first` when no
  /// point was there before, now or in earlier calls. Calls of one shard come one after the other, the points in their
  /// order; those of different shards at the same time.
  template <class Visit>
  void add(std::span<const Eigen::Vector3f> points, const Visit& visit) {
    deal_out(points);
    parallel_for(shards, 4, [&](std::size_t begin, std::size_t end) {
      for (std::size_t s = begin; s < end; ++s) {
        for (const Starts& starts : starts_) {
          for (std::uint32_t k = starts[s]; k < starts[s + 1]; ++k) {
            if (k + ahead < starts[s + 1]) cubes_[s].fetch(keys_[order_[k + ahead]]);
            const KeyNumbers::Met cube = cubes_[s].meet(keys_[order_[k]]);
            visit(s, cube.number, order_[k], cube.first);
          }
        }
      }
    });
  }

 private:
  static constexpr std::uint32_t ahead = 8;  // of the point at hand
  using Starts = std::array<std::uint32_t, shards + 1>;
  void deal_out(std::span<const Eigen::Vector3f> points);

  double per_m_;
  std::array<KeyNumbers, shards> cubes_;
  std::vector<std::uint64_t> keys_;   ///< Of each point of this call.
  std::vector<std::uint32_t> order_;  ///< Points sorted by shard, chunk by chunk.
  std::vector<Starts> starts_;        ///< Of the shards in `order_`, for each chunk.
};

}  // namespace rigcal
