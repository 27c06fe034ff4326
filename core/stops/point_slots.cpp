#include "core/stops/point_slots.h"

#include <algorithm>
#include <limits>

namespace rigcal {
namespace {

// Beside the complete slots those that wait for the slower LiDARs, and what is ahead of them.
constexpr std::int64_t ring_slots = PointSlots::kept + 128;
constexpr std::int64_t patience_ns = 500'000'000;
constexpr std::int64_t jump_ns = 2'000'000'000;
constexpr std::int64_t farthest_ns = std::numeric_limits<std::int64_t>::max() / 4;
constexpr double longest_batch_ns = 1e9;
constexpr std::size_t most_in_slot = 4096;
constexpr std::size_t most_lidars = 32;

}  // namespace

std::size_t PointSlots::place(std::int64_t slot) { return static_cast<std::size_t>(slot % ring_slots); }

std::int64_t PointSlots::first() const { return std::max<std::int64_t>(0, done_ - kept); }

std::span<const RangePoint> PointSlots::points(std::size_t lidar, std::int64_t slot) const {
  return lidars_[lidar].ring[place(slot)];
}

PointSlots::Lidar* PointSlots::find(int sensor) {
  for (Lidar& lidar : lidars_) {
    if (lidar.sensor == sensor) return &lidar;
  }
  if (lidars_.size() >= most_lidars) return nullptr;
  Lidar& lidar = lidars_.emplace_back();
  lidar.sensor = sensor;
  lidar.newest_ns = newest_ns_;
  lidar.ring.resize(static_cast<std::size_t>(ring_slots));
  return &lidar;
}

void PointSlots::restart(std::int64_t stamp_ns) {
  for (Lidar& lidar : lidars_) {
    lidar.newest_ns = stamp_ns;
    for (std::vector<RangePoint>& slot : lidar.ring) slot.clear();
  }
  if (started_) ++epoch_;
  started_ = true;
  origin_ns_ = stamp_ns;
  newest_ns_ = stamp_ns;
  done_ = 0;
}

bool PointSlots::accept_time(std::int64_t stamp_ns) {
  if (stamp_ns < -farthest_ns || stamp_ns > farthest_ns) return false;
  if (!started_ || stamp_ns > newest_ns_ + jump_ns) restart(stamp_ns);
  return stamp_ns >= start_ns(done_);
}

// Which of the points are kept, 0 .. 1. Shots are thinned whether they returned or not; of a cloud nobody knows how
// many there were, so its points are counted.
double PointSlots::share_of(const PointBatch& batch) const {
  if (batch.shots > 0) return std::min(1.0, points_per_s_ * 1e-9 * batch.shot_interval_ns);
  const auto last = std::max_element(batch.points.begin(), batch.points.end(),
                                     [](const Point& a, const Point& b) { return a.shot < b.shot; });
  const double span_ns = batch.shot_interval_ns * (batch.undivided ? 1.0 : last->shot);
  const auto count = static_cast<double>(batch.points.size());
  const double share = span_ns > 0.0 ? std::min(1.0, points_per_s_ * 1e-9 * span_ns / count) : 1.0;
  // What lies in one slot is thinned before that is full: otherwise it would hold a sector of the view.
  const bool in_one_slot = batch.undivided || span_ns < static_cast<double>(length_ns);
  return in_one_slot ? std::min(share, static_cast<double>(most_in_slot) / count) : share;
}

void PointSlots::add(const PointBatch& batch) {
  if (batch.points.empty() || !(batch.shot_interval_ns >= 0.0)) return;
  if (!accept_time(batch.stamp_ns)) return;
  Lidar* lidar = find(batch.sensor);
  if (lidar == nullptr) return;
  const double share = share_of(batch);
  for (const Point& point : batch.points) {
    lidar->share += share > 0.0 ? share : 1.0;
    if (lidar->share < 1.0) continue;
    lidar->share -= 1.0;
    const double after_ns = point.shot * batch.shot_interval_ns;
    if (!(after_ns <= longest_batch_ns)) continue;
    const std::int64_t stamp_ns = batch.stamp_ns + static_cast<std::int64_t>(after_ns);
    const std::int64_t slot = (stamp_ns - origin_ns_) / length_ns;
    if (slot < done_ || slot >= done_ + ring_slots - kept) continue;
    std::vector<RangePoint>& points = lidar->ring[place(slot)];
    if (points.size() >= most_in_slot) continue;
    points.push_back(to_range_point(point.x, point.y, point.z));
    ++used_;
  }
  lidar->newest_ns = std::max(lidar->newest_ns, batch.stamp_ns);
  newest_ns_ = std::max(newest_ns_, batch.stamp_ns);
}

bool PointSlots::complete_next(bool at_end) {
  if (!started_) return false;
  std::int64_t until_ns = newest_ns_;
  for (const Lidar& lidar : lidars_) {
    if (lidar.newest_ns >= newest_ns_ - patience_ns) until_ns = std::min(until_ns, lidar.newest_ns);
  }
  if (at_end ? start_ns(done_) >= newest_ns_ : start_ns(done_ + 1) > until_ns) return false;
  // The place of the slot that leaves the readable ones is used anew.
  const std::int64_t leaving = done_ - kept;
  if (leaving >= 0) {
    for (Lidar& lidar : lidars_) lidar.ring[place(leaving)].clear();
  }
  ++done_;
  return true;
}

}  // namespace rigcal
