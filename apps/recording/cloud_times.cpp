#include "apps/recording/cloud_times.h"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <vector>

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

// The slowest LiDARs that turn take 0.2 s, and drivers gather for a second; times that claim more are not believed, and
// what comes more rarely did not take all the time between.
constexpr std::int64_t longest_cloud_ns = 2'000'000'000;
constexpr std::size_t steps_of_median = 15;

// No recorder is as quick; what a stamp loses as a floating-point number is less.
bool is_stamp_of_header(const RosCloud& cloud, std::int64_t recorded_ns) {
  constexpr std::int64_t rounding_ns = 1000;
  return std::abs(stamp_difference(recorded_ns, cloud.header.stamp_ns)) <= rounding_ns;
}

// Where all points have one time, it is that of the cloud.
bool is_timed(const std::vector<std::int64_t>& times_ns) {
  const auto [first, last] = std::minmax_element(times_ns.begin(), times_ns.end());
  return first != times_ns.end() && (*first < *last || times_ns.size() == 1) &&
         static_cast<double>(*last) - static_cast<double>(*first) <= static_cast<double>(longest_cloud_ns);
}

}  // namespace

std::int64_t CloudTimes::usual_ns() const {
  if (steps_ns_.empty()) return 0;
  std::vector<std::int64_t> steps(steps_ns_.begin(), steps_ns_.end());
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

// The step from the cloud before.
std::int64_t CloudTimes::note_end(std::int64_t end_ns) {
  const std::int64_t step_ns =
      end_ns_ ? std::clamp<std::int64_t>(stamp_difference(end_ns, *end_ns_), 0, longest_cloud_ns) : 0;
  if (end_ns_) steps_ns_.push_back(step_ns);
  if (steps_ns_.size() > steps_of_median) steps_ns_.pop_front();
  end_ns_ = end_ns;
  return step_ns;
}

bool CloudTimes::set(DeviceClock& clock, RosCloud& cloud, std::int64_t recorded_ns, PointBatch& batch) {
  const auto session_ns = [&](std::int64_t sent_ns) {
    return clock.add(sent_ns == 0 ? recorded_ns : sent_ns, recorded_ns).stamp_ns;
  };
  batch.undivided = !is_timed(cloud.times_ns);
  if (batch.undivided) {
    const std::int64_t end_ns = session_ns(cloud.header.stamp_ns);
    const std::int64_t step_ns = note_end(end_ns);
    // No shorter than usual, for a cloud that waited on its way is followed by a short step; not much longer, where one
    // was lost.
    std::int64_t span_ns = std::clamp(step_ns, usual_ns(), usual_ns() * 3 / 2);
    batch.stamp_ns = end_ns - span_ns;
    // Nothing says whether the stamp is of the cloud's start or of its end.
    if (is_stamp_of_header(cloud, recorded_ns)) span_ns += usual_ns();
    batch.shot_interval_ns = static_cast<double>(span_ns);
    return !steps_ns_.empty();
  }
  const auto [first, last] = std::minmax_element(cloud.times_ns.begin(), cloud.times_ns.end());
  const std::int64_t span_ns = *last - *first;
  const bool too_early = is_stamp_of_header(cloud, recorded_ns) && *last > recorded_ns &&
                         stamp_difference(*last, recorded_ns) <= longest_cloud_ns;
  too_early_ = too_early_ || too_early;
  const std::int64_t end_ns = too_early ? *last : session_ns(*last);
  constexpr std::uint16_t last_shot = std::numeric_limits<std::uint16_t>::max();
  batch.stamp_ns = end_ns - span_ns;
  batch.shot_interval_ns = static_cast<double>(span_ns) / last_shot;
  const double per_ns = span_ns > 0 ? last_shot / static_cast<double>(span_ns) : 0.0;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    cloud.points[i].shot = static_cast<std::uint16_t>(static_cast<double>(cloud.times_ns[i] - *first) * per_ns + 0.5);
  }
  static_cast<void>(note_end(end_ns));
  return true;
}

}  // namespace rigcal
