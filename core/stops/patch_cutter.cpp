#include "core/stops/patch_cutter.h"

#include <algorithm>

#include "core/base/error.h"
#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr std::int64_t memory_ns = 2'000'000'000;  // batches later than this are counted, not looked up
// So many points wait however long it takes, and more only where they come so densely: no verdict takes so long.
constexpr std::size_t points_that_wait = 4'000'000;
constexpr std::int64_t longest_wait_ns = 5'000'000'000;

}  // namespace

PatchCutter::PatchCutter(std::size_t max_held_points, PatchSink& sink)
    : sink_(sink), most_blocks_(max_held_points / block_points) {
  RIGCAL_ASSERT(most_blocks_ > 0, "max_held_points must be at least one block of " + std::to_string(block_points));
}

void PatchCutter::add(const PointBatch& batch) {
  if (batch.points.empty()) return;
  // The last point's shot: that a batch reaches past a decision matters only where it has points.
  const std::uint16_t last_shot =
      std::max_element(batch.points.begin(), batch.points.end(), [](const Point& a, const Point& b) {
        return a.shot < b.shot;
      })->shot;
  const int shots = batch.undivided ? 1 : last_shot;
  const std::int64_t end_ns = batch.stamp_ns + static_cast<std::int64_t>(shots * batch.shot_interval_ns) + 1;
  Queue& queue = queues_[batch.sensor];
  for (std::span<const Point> left(batch.points); !left.empty();) {
    const std::size_t count = make_place(queue, left.size(), batch.stamp_ns);
    if (count == 0) {
      counts_.dropped[static_cast<std::size_t>(DropReason::overflow)] += left.size();
      break;
    }
    hold(queue, batch, left.first(count), end_ns);
    left = left.subspan(count);
  }
  drain(batch.sensor, queue);
}

// How many of `points` fit into the sensor's last block, or into a fresh one; 0: there is none. A packet stays whole.
std::size_t PatchCutter::make_place(Queue& queue, std::size_t points, std::int64_t now_ns) {
  constexpr std::size_t little = block_points / 16;
  const std::size_t left = block_points - queue.filled;
  if (points > left && left < little && !take_block(queue, now_ns)) return 0;
  return std::min(points, block_points - queue.filled);
}

void PatchCutter::hold(Queue& queue, const PointBatch& batch, std::span<const Point> points, std::int64_t end_ns) {
  Block* block = queue.blocks.back().get();
  std::copy(points.begin(), points.end(), block->points.begin() + static_cast<std::ptrdiff_t>(queue.filled));
  queue.held.push_back(
      {batch.stamp_ns, batch.shot_interval_ns, end_ns, block, queue.filled, points.size(), batch.undivided});
  queue.filled += points.size();
}

// A fresh last block: a used one, a new one, or the sensor's own oldest.
bool PatchCutter::take_block(Queue& queue, std::int64_t now_ns) {
  if (free_blocks_.empty() && may_make_block(queue, now_ns)) {
    ++blocks_;
    free_blocks_.push_back(std::make_unique<Block>());
  }
  while (free_blocks_.empty() && !queue.held.empty()) {
    counts_.dropped[static_cast<std::size_t>(DropReason::overflow)] += queue.held.front().count;
    drop_head(queue, free_blocks_);
  }
  if (free_blocks_.empty()) return false;
  queue.blocks.push_back(std::move(free_blocks_.back()));
  free_blocks_.pop_back();
  queue.filled = 0;
  return true;
}

bool PatchCutter::may_make_block(const Queue& queue, std::int64_t now_ns) const {
  if (blocks_ >= most_blocks_) return false;
  return blocks_ < points_that_wait / block_points || queue.held.empty() ||
         stamp_difference(now_ns, queue.held.front().stamp_ns) < longest_wait_ns;
}

void PatchCutter::drop_head(Queue& queue, std::vector<std::unique_ptr<Block>>& free_blocks) {
  const Block* block = queue.held.front().block;
  queue.held.pop_front();
  if (!queue.held.empty() && queue.held.front().block == block) return;
  free_blocks.push_back(std::move(queue.blocks.front()));
  queue.blocks.pop_front();
  if (queue.blocks.empty()) queue.filled = block_points;
}

void PatchCutter::not_still_until(std::int64_t until_ns, DropReason reason) { decide({until_ns, -1, reason}); }

void PatchCutter::still_until(std::int64_t until_ns, int stop) { decide({until_ns, stop, DropReason::late}); }

void PatchCutter::decide(const Verdict& verdict) {
  if (!verdicts_.empty()) {
    Verdict& last = verdicts_.back();
    if (verdict.until_ns <= last.until_ns) return;
    if (last.stop == verdict.stop && last.reason == verdict.reason) {
      last.until_ns = verdict.until_ns;
    } else {
      verdicts_.push_back(verdict);
    }
  } else {
    verdicts_.push_back(verdict);
  }
  while (verdicts_.size() > 1 && verdicts_.front().until_ns < verdict.until_ns - memory_ns) {
    forgotten_until_ns_ = verdicts_.front().until_ns;
    verdicts_.pop_front();
  }
  for (auto& [sensor, queue] : queues_) drain(sensor, queue);
}

void PatchCutter::drain(int sensor, Queue& queue) {
  while (!queue.held.empty() && !verdicts_.empty() && queue.held.front().end_ns <= verdicts_.back().until_ns) {
    hand_out(sensor, queue, queue.held.front());
    drop_head(queue, free_blocks_);
  }
}

void PatchCutter::hand_out(int sensor, Queue& queue, const Held& held) {
  const std::span<const Point> points(held.block->points.data() + held.first, held.count);
  const ShotTimes times{held.stamp_ns, held.shot_interval_ns};
  const Verdict forgotten{forgotten_until_ns_, -1, DropReason::late};
  const auto verdict_at = [&](std::int64_t stamp_ns) -> const Verdict& {
    if (stamp_ns < forgotten_until_ns_) return forgotten;
    return *std::upper_bound(verdicts_.begin(), verdicts_.end(), stamp_ns,
                             [](std::int64_t stamp, const Verdict& verdict) { return stamp < verdict.until_ns; });
  };
  const Verdict& first = verdict_at(held.stamp_ns);
  if (held.end_ns <= first.until_ns) {
    deliver(sensor, queue, first, times, points);
    return;
  }
  if (held.undivided) {
    // Some of its points are of the time when the rig moved, and none says which.
    const Verdict& last = verdict_at(held.end_ns - 1);
    counts_.dropped[static_cast<std::size_t>(first.stop < 0 ? first.reason : last.reason)] += points.size();
    return;
  }
  // The batch straddles a border: cut by shot time.
  const auto of_point = [&](const Point& point) -> const Verdict& { return verdict_at(held.time_of(point)); };
  for (std::size_t begin = 0; begin < points.size();) {
    const Verdict& verdict = of_point(points[begin]);
    std::size_t end = begin + 1;
    while (end < points.size() && &of_point(points[end]) == &verdict) ++end;
    deliver(sensor, queue, verdict, times, points.subspan(begin, end - begin));
    begin = end;
  }
}

void PatchCutter::deliver(int sensor, Queue& queue, const Verdict& verdict, const ShotTimes& times,
                          std::span<const Point> points) {
  if (verdict.stop < 0 || verdict.stop <= last_stop_done_) {
    const DropReason reason = verdict.stop < 0 ? verdict.reason : DropReason::late;
    counts_.dropped[static_cast<std::size_t>(reason)] += points.size();
    return;
  }
  counts_.in_stops += points.size();
  queue.points_in_stop += points.size();
  sink_.timed_points(sensor, verdict.stop, times, points);
}

// Clouds are long: the end of a stop is in one that reaches beyond what is decided, and would be handed out too late.
void PatchCutter::hand_out_decided(int sensor, Queue& queue) {
  const std::int64_t until_ns = verdicts_.empty() ? forgotten_until_ns_ : verdicts_.back().until_ns;
  for (Held& held : queue.held) {
    if (held.undivided || held.stamp_ns >= until_ns) continue;
    const auto first = held.block->points.begin() + static_cast<std::ptrdiff_t>(held.first);
    const auto open = std::stable_partition(first, first + static_cast<std::ptrdiff_t>(held.count),
                                            [&](const Point& point) { return held.time_of(point) < until_ns; });
    Held decided = held;
    decided.count = static_cast<std::size_t>(open - first);
    held.first += decided.count;
    held.count -= decided.count;
    if (decided.count > 0) hand_out(sensor, queue, decided);
  }
}

void PatchCutter::stop_ended(const StillStop& stop) {
  for (auto& [sensor, queue] : queues_) hand_out_decided(sensor, queue);
  StopRecord record{stop, {}};
  for (auto& [sensor, queue] : queues_) {
    if (queue.points_in_stop > 0) record.points[sensor] = queue.points_in_stop;
    queue.points_in_stop = 0;
  }
  last_stop_done_ = stop.stop.index;
  sink_.stop_done(record);
}

void PatchCutter::flush() {
  for (auto& [sensor, queue] : queues_) {
    for (; !queue.held.empty(); drop_head(queue, free_blocks_)) {
      const DropReason reason = last_stop_done_ < 0 ? DropReason::before_first_stop : DropReason::after_last_stop;
      counts_.dropped[static_cast<std::size_t>(reason)] += queue.held.front().count;
    }
  }
}

}  // namespace rigcal
