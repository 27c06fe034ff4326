#include "simdata/gige/exposure_schedule.h"

#include <algorithm>

#include "simdata/gige/features.h"

namespace rigcal::sim {
namespace {

constexpr std::size_t most_triggers = 4096;  // That wait for their delay to pass.

}  // namespace

void ExposureSchedule::start(std::int64_t now_ns, const ExposureRules& rules, std::uint64_t frames) {
  stop();
  rules_ = rules;
  is_running_ = true;
  frames_left_ = frames;
  has_end_ = frames > 0;
  free_start_ns_ = now_ns;
  blocked_until_ns_ = INT64_MIN;
}

void ExposureSchedule::stop() {
  is_running_ = false;
  triggers_.clear();
  exposing_.reset();
}

void ExposureSchedule::set_rules(std::int64_t now_ns, const ExposureRules& rules) {
  if (rules.is_triggered != rules_.is_triggered || rules.source != rules_.source) triggers_.clear();
  if (rules_.is_triggered && !rules.is_triggered) free_start_ns_ = now_ns;
  rules_ = rules;
}

void ExposureSchedule::add(const Start& start) {
  if (triggers_.size() >= most_triggers) return;
  const auto later = [](const Start& a, const Start& b) { return a.time_ns < b.time_ns; };
  triggers_.insert(std::upper_bound(triggers_.begin(), triggers_.end(), start, later), start);
}

void ExposureSchedule::pulse(const LinePulse& pulse) {
  if (!is_running_ || !rules_.is_triggered || rules_.source != pulse.line) return;
  add({(rules_.on_falling_edge ? pulse.fall_ns : pulse.rise_ns) + rules_.delay_ns, pulse.number});
}

void ExposureSchedule::software_trigger(std::int64_t now_ns) {
  if (!is_running_ || !rules_.is_triggered || rules_.source != kSoftwareTrigger) return;
  add({now_ns + rules_.delay_ns, std::nullopt});
}

std::optional<ExposureSchedule::Start> ExposureSchedule::next_start(std::int64_t now_ns) {
  if (!rules_.is_triggered) {
    const std::int64_t start = std::max(free_start_ns_, blocked_until_ns_);
    if (start > now_ns) return std::nullopt;
    free_start_ns_ = start + rules_.period_ns;
    return Start{start, std::nullopt};
  }
  while (!triggers_.empty() && triggers_.front().time_ns <= now_ns) {
    const Start start = triggers_.front();
    triggers_.pop_front();
    if (start.time_ns >= blocked_until_ns_) return start;
    ++ignored_;
  }
  return std::nullopt;
}

std::optional<Exposure> ExposureSchedule::take(std::int64_t now_ns) {
  if (!is_running_) return std::nullopt;
  if (!exposing_) {
    const auto start = next_start(now_ns);
    if (!start) return std::nullopt;
    exposing_ = Exposure{start->time_ns, start->time_ns + rules_.exposure_ns, start->pulse};
    blocked_until_ns_ = start->time_ns + std::max(rules_.exposure_ns, rules_.shortest_period_ns);
  }
  if (exposing_->end_ns > now_ns) return std::nullopt;
  const Exposure done = *exposing_;
  exposing_.reset();
  if (has_end_ && --frames_left_ == 0) stop();
  return done;
}

std::int64_t ExposureSchedule::deadline_ns() const {
  if (!is_running_) return INT64_MAX;
  if (exposing_) return exposing_->end_ns;
  if (!rules_.is_triggered) return std::max(free_start_ns_, blocked_until_ns_);
  return triggers_.empty() ? INT64_MAX : triggers_.front().time_ns;
}

}  // namespace rigcal::sim
