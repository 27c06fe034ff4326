#include "core/stops/motion_bins.h"

#include <algorithm>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

constexpr std::int64_t hold_back_ns = 20'000'000;  // four samples at 200 Hz: a switch never mixes packets further
constexpr std::int64_t last_stamp_ns = std::numeric_limits<std::int64_t>::max() / 4;

// What no unit can measure is a damaged packet: one such reading would spoil a whole turn. MEMS gyros end at 4000
// deg/s.
constexpr double most_gyro_rad_s = 70.0;
constexpr double most_acceleration_g = 1000.0;

// Nor is what is no number.
bool is_possible(const Vector3d& reading, double most) { return (reading.array().abs() <= most).all(); }

bool is_usable(const ImuSample& sample) {
  return sample.stamp_ns >= -last_stamp_ns && sample.stamp_ns <= last_stamp_ns &&
         is_possible(sample.gyro_rad_s, most_gyro_rad_s) && is_possible(sample.acceleration_g, most_acceleration_g);
}

}  // namespace

const std::vector<MotionBin>& MotionBinner::add(const ImuSample& sample) {
  ready_.clear();
  if (!is_usable(sample) || sample.stamp_ns < last_ns_) {
    ++unusable_;
    return ready_;
  }
  const auto place = std::lower_bound(waiting_.begin(), waiting_.end(), sample.stamp_ns,
                                      [](const ImuSample& s, std::int64_t stamp) { return s.stamp_ns < stamp; });
  if (sample.stamp_ns == last_ns_ || (place != waiting_.end() && place->stamp_ns == sample.stamp_ns)) {
    return ready_;
  }
  waiting_.insert(place, sample);
  const std::int64_t until = waiting_.back().stamp_ns - hold_back_ns;
  std::size_t count = 0;
  while (waiting_[count].stamp_ns <= until) release(waiting_[count++]);
  waiting_.erase(waiting_.begin(), waiting_.begin() + static_cast<std::ptrdiff_t>(count));
  return ready_;
}

const std::vector<MotionBin>& MotionBinner::flush() {
  ready_.clear();
  for (const ImuSample& sample : waiting_) release(sample);
  waiting_.clear();
  has_open_ = false;
  return ready_;
}

void MotionBinner::release(const ImuSample& sample) {
  open_bin_for(sample.stamp_ns);
  if (last_ns_ != std::numeric_limits<std::int64_t>::min()) {
    const double dt = seconds_of_ns(sample.stamp_ns - last_ns_);
    open_.turn += 0.5 * dt * (last_.gyro_rad_s + sample.gyro_rad_s);
    open_.turn_s += dt;
    open_.longest_interval_s = std::max(open_.longest_interval_s, dt);
  }
  ++open_.samples;
  const Vector3d from_old_mean = sample.gyro_rad_s - open_.gyro_mean;
  open_.gyro_mean += from_old_mean / open_.samples;
  open_.gyro_scatter += from_old_mean.cwiseProduct(sample.gyro_rad_s - open_.gyro_mean);
  open_.acceleration_mean += (sample.acceleration_g - open_.acceleration_mean) / open_.samples;
  last_ = sample;
  last_ns_ = sample.stamp_ns;
  ++used_;
}

void MotionBinner::open_bin_for(std::int64_t stamp_ns) {
  if (!has_open_) {
    open_ = MotionBin{};
    open_.start_ns = stamp_ns;
    has_open_ = true;
    return;
  }
  for (int empty = -1; stamp_ns >= open_.end_ns(); ++empty) {
    const std::int64_t next_ns = empty < max_empty_bins ? open_.end_ns() : stamp_ns;
    ready_.push_back(open_);
    open_ = MotionBin{};
    open_.start_ns = next_ns;
  }
}

}  // namespace rigcal
