#include "core/clocks/onward_time.h"

#include <algorithm>
#include <utility>

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr std::int64_t near_ns = 1'000'000'000;
constexpr int strays_of_step = 5;  // as few as a DeviceClock takes for a jump: one less, and it would see it first

bool are_near(std::int64_t a, std::int64_t b) {
  const std::int64_t apart = stamp_difference(a, b);
  return apart >= -near_ns && apart <= near_ns;
}

}  // namespace

bool OnwardTime::is_near(std::int64_t time_ns) const { return started_ && are_near(time_ns, newest_ns_); }

std::int64_t OnwardTime::add(std::int64_t stamp_ns, std::uint64_t place) {
  std::int64_t time_ns = stamp_sum(stamp_ns, added_ns_);
  if (!is_near(time_ns) && is_near(stamp_sum(stamp_ns, other_added_ns_))) {
    std::swap(added_ns_, other_added_ns_);
    time_ns = stamp_sum(stamp_ns, added_ns_);
  }
  if (is_near(time_ns)) {
    strays_ = 0;
    newest_ns_ = std::max(newest_ns_, time_ns);
    return time_ns;
  }
  if (strays_ == 0 || !are_near(time_ns, last_stray_ns_)) {
    strays_ = 0;
    first_stray_ns_ = time_ns;
    stray_place_ = place;
  }
  last_stray_ns_ = time_ns;
  if (++strays_ == strays_of_step) confirm(time_ns);
  return stamp_sum(stamp_ns, added_ns_);
}

void OnwardTime::confirm(std::int64_t time_ns) {
  strays_ = 0;
  const std::int64_t back_ns = stamp_difference(newest_ns_, first_stray_ns_);
  if (!started_ || back_ns <= 0) {  // the beginning, a silence, or a clock that was set forward
    started_ = true;
    newest_ns_ = time_ns;
    return;
  }
  other_added_ns_ = std::exchange(added_ns_, stamp_sum(added_ns_, back_ns));
  newest_ns_ = std::max(newest_ns_, stamp_sum(time_ns, back_ns));
  if (++steps_ > 1) return;
  first_step_ns_ = back_ns;
  first_place_ = stray_place_;
}

}  // namespace rigcal
