#include "core/clocks/offset_line.h"

#include <algorithm>
#include <limits>

namespace rigcal {
namespace {

constexpr double bin_ns = 1e8;              // 0.1 s: 50 to 250 packets, enough for one that was hardly delayed.
constexpr double slope_span_ns = 0.5e9;     // Shorter spans say more of the jitter than of the drift.
constexpr double max_slope = 500e-6;        // Crystals are within 100 ppm; a PTP slave's servo steers by a few hundred.
constexpr double max_age_ns = 20e9;         // Older points (before a pause) say nothing of the offset of now.
constexpr double lowered_restart_ns = 2e6;  // 2 ms below the line is no jitter: the line stood on delayed packets.

}  // namespace

void OffsetLine::restart(double time, double offset) {
  count_ = 0;
  open_ = {time, offset};
  bin_start_ = time;
  start_ = time;
  lowered_ = 0.0;
  time_ = time;
  offset_ = offset;
}

bool OffsetLine::add(double time, double offset) {
  const bool full = time >= bin_start_ + bin_ns;
  if (full) close_bin(time);
  const double height = offset - at(time);
  if (height < 0.0) {
    offset_ += height;
    lowered_ -= height;
    if (lowered_ > lowered_restart_ns) {
      restart(time, offset);
      return true;
    }
  }
  const bool earlier = time >= bin_start_ && offset - slope_ * (time - open_.time) < open_.offset;
  if (full || earlier) open_ = {time, offset};
  return full || height < 0.0;
}

void OffsetLine::close_bin(double time) {
  if (count_ == kCapacity) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  ring_[(first_ + count_) % kCapacity] = open_;
  ++count_;
  while (count_ > 1 && early(0).time < time - max_age_ns) {
    first_ = (first_ + 1) % kCapacity;
    --count_;
  }
  bin_start_ = time;
  lowered_ = 0.0;
  fit(time);
}

void OffsetLine::fit(double now) {
  if (early(count_ - 1).time - early(0).time >= slope_span_ns) {
    slope_ = std::clamp(hull_slope(), -max_slope, max_slope);
  }
  time_ = now;
  offset_ = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < count_; ++i) {
    offset_ = std::min(offset_, early(i).offset - slope_ * (early(i).time - now));
  }
}

double OffsetLine::hull_slope() const {
  std::array<Early, kCapacity> hull;
  std::size_t size = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const Early& next = early(i);
    while (size >= 2) {
      const Early& a = hull[size - 2];
      const Early& b = hull[size - 1];
      const double turn = (b.time - a.time) * (next.offset - a.offset) - (b.offset - a.offset) * (next.time - a.time);
      if (turn > 0.0) break;
      --size;
    }
    hull[size++] = next;
  }
  const double middle = 0.5 * (hull[0].time + hull[size - 1].time);
  std::size_t right = 1;
  while (right + 1 < size && hull[right].time < middle) ++right;
  const Early& a = hull[right - 1];
  const Early& b = hull[right];
  return (b.offset - a.offset) / (b.time - a.time);
}

double OffsetLine::recent_height() const {
  if (count_ < kRecent) return 0.0;
  double lowest = std::numeric_limits<double>::infinity();
  for (std::size_t i = count_ - kRecent; i < count_; ++i) {
    lowest = std::min(lowest, early(i).offset - at(early(i).time));
  }
  return lowest;
}

void OffsetLine::keep_recent() {
  const std::size_t dropped = count_ - std::min(count_, kRecent);
  first_ = (first_ + dropped) % kCapacity;
  count_ -= dropped;
  start_ = early(0).time;
  fit(bin_start_);
}

}  // namespace rigcal
