#pragma once

#include <cstdint>
#include <deque>
#include <vector>

#include "core/records/records.h"
#include "core/stops/range_reference.h"

namespace rigcal {

/// The points of all LiDARs, thinned, in common slots of 25 ms of session time. A slot is complete when all LiDARs that
/// spoke in the last half second are past it; what comes later is not looked at. The last `kept` complete slots can be
/// read. After a jump of more than two seconds the slots start anew: `epoch` tells.
class PointSlots {
 public:
  static constexpr std::int64_t length_ns = 25'000'000;
  static constexpr std::int64_t kept = 80;

  /// More than `points_per_s` of a LiDAR are thinned.
  explicit PointSlots(double points_per_s) : points_per_s_(points_per_s) {}
  /// Points out of any range of time or space that makes sense are left out.
  void add(const PointBatch& batch);
  /// The next slot that is complete, oldest first; false: none. With `at_end` the open ones too.
  [[nodiscard]] bool complete_next(bool at_end);

  [[nodiscard]] std::int64_t last() const { return done_ - 1; }  ///< The slot completed last.
  [[nodiscard]] std::int64_t first() const;                      ///< The oldest one that can be read.
  [[nodiscard]] std::int64_t start_ns(std::int64_t slot) const { return origin_ns_ + slot * length_ns; }
  [[nodiscard]] std::span<const RangePoint> points(std::size_t lidar, std::int64_t slot) const;
  [[nodiscard]] std::size_t lidars() const { return lidars_.size(); }
  [[nodiscard]] int sensor(std::size_t lidar) const { return lidars_[lidar].sensor; }
  [[nodiscard]] int epoch() const { return epoch_; }
  [[nodiscard]] std::uint64_t used() const { return used_; }  ///< Points looked at.

 private:
  struct Lidar {
    int sensor = -1;
    std::int64_t newest_ns = 0;
    double share = 0.0;  ///< Of the next point that is kept: it is when this reaches 1.
    std::vector<std::vector<RangePoint>> ring;
  };
  [[nodiscard]] Lidar* find(int sensor);
  [[nodiscard]] bool accept_time(std::int64_t stamp_ns);
  [[nodiscard]] double share_of(const PointBatch& batch) const;
  void restart(std::int64_t stamp_ns);
  static std::size_t place(std::int64_t slot);

  double points_per_s_;
  std::deque<Lidar> lidars_;
  std::int64_t origin_ns_ = 0;
  std::int64_t newest_ns_ = 0;
  std::int64_t done_ = 0;  ///< The first slot that is not complete.
  bool started_ = false;
  int epoch_ = 0;
  std::uint64_t used_ = 0;
};

}  // namespace rigcal
