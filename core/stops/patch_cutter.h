#pragma once

#include <array>
#include <deque>
#include <limits>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "core/stops/still_listener.h"

namespace rigcal {

/// A stop and what came of it.
struct StopRecord : StillStop {
  std::map<int, std::uint64_t> points;  ///< Points in the stop for each sensor that had any.
};

/// When points were seen: Point::shot counts from `stamp_ns` in steps of `shot_interval_ns`, session time.
struct ShotTimes {
  std::int64_t stamp_ns = 0;
  double shot_interval_ns = 0.0;
};

/// Where the points of the stops go. A stop's points come before its `stop_done`, those of one sensor in the order in
/// which they arrived; stops come in order.
class PatchSink {
 public:
  virtual ~PatchSink() = default;
  /// `points` lives only for the call.
  virtual void points(int sensor, int stop, std::span<const Point> points) = 0;
  /// The same for who wants the points' times too; `points` need not do anything then.
  virtual void timed_points(int sensor, int stop, const ShotTimes& /*times*/, std::span<const Point> part) {
    points(sensor, stop, part);
  }
  virtual void stop_done(const StopRecord& stop) = 0;
};

struct PointCounts {
  std::uint64_t in_stops = 0;
  std::array<std::uint64_t, drop_reasons> dropped{};  ///< Indexed by DropReason.
};

/// Holds points until it is told whether the rig stood still at their time, and hands those of stops to the sink. One
/// queue a sensor, so that sensors may lag each other; the memory is taken in blocks up to `max_held_points` and used
/// over and over. When that is full the sensor's oldest points are dropped and counted; beyond 4 million so are those
/// that wait for more than 5 s, for example where the inertial unit keeps silent.
class PatchCutter final : public StillListener {
 public:
  PatchCutter(std::size_t max_held_points, PatchSink& sink);
  void add(const PointBatch& batch);
  void not_still_until(std::int64_t until_ns, DropReason reason) override;
  void still_until(std::int64_t until_ns, int stop) override;
  void stop_ended(const StillStop& stop) override;
  /// The end of the stream: drops what nothing was said about.
  void flush();
  [[nodiscard]] const PointCounts& counts() const { return counts_; }

 private:
  static constexpr std::size_t block_points = 16384;  // 256 KB: much more than a packet, little for one sensor
  struct Block {
    std::array<Point, block_points> points;
  };
  struct Held {
    std::int64_t stamp_ns;
    double shot_interval_ns;
    std::int64_t end_ns;  ///< Just after the last shot.
    Block* block;
    std::size_t first;
    std::size_t count;
    bool undivided;
    [[nodiscard]] std::int64_t time_of(const Point& point) const {
      return stamp_ns + static_cast<std::int64_t>(point.shot * shot_interval_ns);
    }
  };
  struct Queue {
    std::deque<Held> held;
    std::deque<std::unique_ptr<Block>> blocks;  ///< The last one is being filled.
    std::size_t filled = block_points;          ///< Of the last block.
    std::uint64_t points_in_stop = 0;
  };
  struct Verdict {
    std::int64_t until_ns;
    int stop;  ///< -1: none, see `reason`.
    DropReason reason;
  };
  void decide(const Verdict& verdict);
  void drain(int sensor, Queue& queue);
  void hand_out_decided(int sensor, Queue& queue);
  void hand_out(int sensor, Queue& queue, const Held& held);
  void deliver(int sensor, Queue& queue, const Verdict& verdict, const ShotTimes& times, std::span<const Point> points);
  void hold(Queue& queue, const PointBatch& batch, std::span<const Point> points, std::int64_t end_ns);
  [[nodiscard]] std::size_t make_place(Queue& queue, std::size_t points, std::int64_t now_ns);
  [[nodiscard]] bool take_block(Queue& queue, std::int64_t now_ns);
  [[nodiscard]] bool may_make_block(const Queue& queue, std::int64_t now_ns) const;
  static void drop_head(Queue& queue, std::vector<std::unique_ptr<Block>>& free_blocks);

  PatchSink& sink_;
  std::size_t most_blocks_;
  std::size_t blocks_ = 0;  ///< Made so far.
  std::vector<std::unique_ptr<Block>> free_blocks_;
  std::map<int, Queue> queues_;
  std::deque<Verdict> verdicts_;  ///< In order of time; the last two seconds and what is later.
  std::int64_t forgotten_until_ns_ = std::numeric_limits<std::int64_t>::min();
  int last_stop_done_ = -1;
  PointCounts counts_;
};

}  // namespace rigcal
