#include "core/stops/creep_guard.h"

#include <algorithm>
#include <utility>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

// The points' verdicts come about as late as the gyro's, or half a second later.
constexpr std::int64_t verdict_lag_ns = 500'000'000;

}  // namespace

void CreepGuard::not_still_until(std::int64_t until_ns, DropReason reason) {
  finish_rest();
  begin_ns_ = std::max(begin_ns_, until_ns);
  listener_.not_still_until(until_ns, reason);
}

void CreepGuard::still_until(std::int64_t until_ns, int stop) {
  rest_ = {until_ns, stop};
  look_for_cut();
  const std::int64_t known_ns = until_ns - verdict_lag_ns;
  if (cut_ns_ || known_ns < begin_ns_ + whole_ns_of_seconds(options_.min_stop_s)) return;
  handed_on_ = true;
  listener_.still_until(known_ns, stop);
}

void CreepGuard::finish_rest() {
  if (!rest_) return;
  look_for_cut();
  if (!cut_ns_) listener_.still_until(rest_->until_ns, rest_->stop);
  rest_.reset();
}

void CreepGuard::stop_ended(const StillStop& stop) {
  finish_rest();
  StillStop kept = stop;
  if (start_ns_) kept.stop.start_ns = std::min(*start_ns_, stop.stop.end_ns);
  if (cut_ns_) {
    kept.stop.end_ns = std::min(stop.stop.end_ns, *cut_ns_ - 1);
    kept.end = StopEnd::creep;
    crept_->end(stop.stop.end_ns);
  }
  if (crept_before_) crept_before_->put_before(kept);
  crept_before_ = std::move(crept_);
  crept_.reset();
  start_ns_.reset();
  cut_ns_.reset();
  handed_on_ = false;
  listener_.stop_ended(kept);
}

void CreepGuard::take_rest(const StillStop& rest) {
  if (rest.end == StopEnd::motion) left_ = rest.stop;
  if (crept_) crept_->add(rest);
  // The last one of the stop before is told only when it is over.
  if (crept_before_) crept_before_->add(rest);
}

// Where the points saw the rig leave its place in this very stop, earlier than its end by more than both could be
// wrong.
void CreepGuard::look_for_cut() {
  if (cut_ns_ || !left_) return;
  const std::int64_t end_ns = left_->end_ns + 1;
  if (end_ns + verdict_lag_ns > rest_->until_ns) return;
  if (end_ns >= begin_ns_ + whole_ns_of_seconds(options_.min_stop_s)) {
    cut_ns_ = end_ns;
    crept_.emplace(options_, end_ns);
    listener_.still_until(end_ns, rest_->stop);
    listener_.not_still_until(rest_->until_ns, DropReason::moving);
  } else if (end_ns > begin_ns_ && !handed_on_) {
    cut_beginning(end_ns);
  }
  left_.reset();
}

// The rig left too early for a stop: the rest that is meant is the one that follows.
void CreepGuard::cut_beginning(std::int64_t end_ns) {
  begin_ns_ = end_ns + verdict_lag_ns;
  start_ns_ = begin_ns_;
  listener_.not_still_until(begin_ns_, DropReason::moving);
}

}  // namespace rigcal
