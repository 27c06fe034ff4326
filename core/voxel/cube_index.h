#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/parallel.h"

namespace rigcal {

/// The cube of edge 1 / `per_m` that holds p, as one number; cubes within 2^20 edges of the origin have different ones.
[[nodiscard]] std::uint64_t cube_key(const Eigen::Vector3f& p, double per_m);

/// The corner of a key's cube at which all coordinates are least, in edges.
[[nodiscard]] Eigen::Vector3d cube_corner(std::uint64_t key);

/// Numbers keys 0, 1, 2 .. in the order in which they are first met: open addressing.
class KeyNumbers {
 public:
  struct Met {
    std::uint32_t number = 0;
    bool first = false;
  };
  static constexpr std::uint32_t unknown = ~std::uint32_t{0};

  Met meet(std::uint64_t key);
  /// The number of a key, `unknown` where it was never met.
  [[nodiscard]] std::uint32_t find(std::uint64_t key) const;
  [[nodiscard]] std::uint32_t size() const { return used_; }
  /// Which of 64 shards a key belongs to, by other bits than its place in a table.
  static std::size_t shard(std::uint64_t key) { return static_cast<std::size_t>(mixed(key) >> 58); }
  /// Says that a key will be asked for soon: tables are larger than caches.
  void fetch(std::uint64_t key) const { __builtin_prefetch(&slots_[first_slot(key)]); }

 private:
  /// Where a key is looked for first.
  [[nodiscard]] std::size_t first_slot(std::uint64_t key) const {
    return static_cast<std::size_t>(mixed(key) >> 8) & (slots_.size() - 1);
  }
  static std::uint64_t mixed(std::uint64_t key) {
    key *= 0x9E3779B97F4A7C15ULL;
    return key ^ key >> 29;
  }
  [[nodiscard]] std::size_t slot(std::uint64_t key) const;
  void grow();

  static constexpr std::uint64_t none = ~std::uint64_t{0};
  struct Slot {
    std::uint64_t key = none;
    std::uint32_t number = 0;
  };
  std::vector<Slot> slots_ = std::vector<Slot>(1 << 10);
  std::uint32_t used_ = 0;
};

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
