#include "core/stops/still_detector.h"

#include <algorithm>

#include "core/base/seconds.h"
#include "core/stops/swing.h"

namespace rigcal {

StillDetector::StillDetector(const StopOptions& options, StillListener& listener)
    : options_(options), listener_(listener), judge_(options), imu_sensor_(options.imu_sensor) {
  static_assert(StopOptions::bridge_gap_s <= 0.3, "no more is bridged than the judge looks back on");
}

void StillDetector::add(const ImuSample& sample) {
  if (imu_sensor_ < 0) imu_sensor_ = sample.sensor;
  if (sample.sensor != imu_sensor_) {
    ++imu_of_others_;
    return;
  }
  add_bins(binner_.add(sample));
}

void StillDetector::flush() {
  add_bins(binner_.flush());
  take_finals(true);
  if (state_ == State::candidate) reject_candidate();
  if (state_ == State::stopped) end_stop(StopEnd::stream);
}

void StillDetector::add_bins(const std::vector<MotionBin>& bins) {
  for (const MotionBin& bin : bins) {
    judge_.add(bin);
    take_finals(false);
  }
}

void StillDetector::take_finals(bool at_end) {
  while (const std::optional<MotionBin> bin = judge_.take_final(at_end)) {
    step(*bin);
    brief_rests_.add(*bin, judge_.bias(), state_ == State::stopped);
  }
}

void StillDetector::step(const MotionBin& bin) {
  if (bin.moving) {
    if (state_ == State::candidate) reject_candidate();
    if (state_ == State::stopped) end_stop(bin.silent ? StopEnd::silence : StopEnd::motion);
    state_ = State::moving;
    if (stops_ > 0) turn_.add(bin);
    not_still(bin.end_ns(), DropReason::moving);
    return;
  }
  if (state_ == State::moving) begin_candidate(bin);
  still_end_ns_ = bin.end_ns();
  longest_still_s_ = std::max(longest_still_s_, seconds_of_ns(still_end_ns_ - run_start_ns_));
  if (state_ == State::candidate) {
    extend_candidate(bin);
  } else {
    judge_.learn_from_last();
    extend_stop(bin);
  }
}

void StillDetector::begin_candidate(const MotionBin& bin) {
  state_ = State::candidate;
  run_start_ns_ = bin.start_ns;
  not_still(bin.start_ns, DropReason::moving);
  const StillJudge::Surroundings around = judge_.around_last();
  const std::int64_t settled_ns =
      swing_settled_ns(around.bins, around.last, judge_.bias(), judge_.noise_variance(), options_.angle_limit_rad);
  const std::int64_t latest_ns = bin.start_ns + whole_ns_of_seconds(options_.max_settle_s);
  start_ns_ =
      std::min(std::max(settled_ns, judge_.turn_faded_ns()), latest_ns) + whole_ns_of_seconds(options_.margin_s);
}

void StillDetector::extend_candidate(const MotionBin& bin) {
  if (bin.end_ns() <= start_ns_) {  // the swing still counts to the turn
    if (stops_ > 0) turn_.add(bin);
    not_still(bin.end_ns(), DropReason::swing);
    return;
  }
  candidate_.push_back(bin);
  if (bin.end_ns() - whole_ns_of_seconds(options_.margin_s) - start_ns_ >= whole_ns_of_seconds(options_.min_stop_s))
    confirm_candidate();
}

void StillDetector::reject_candidate() {
  for (const MotionBin& bin : candidate_) {
    if (stops_ > 0) turn_.add(bin);
  }
  candidate_.clear();
  not_still(still_end_ns_, DropReason::short_stop);
  state_ = State::moving;
}

void StillDetector::confirm_candidate() {
  state_ = State::stopped;
  not_still(start_ns_, DropReason::swing);
  open_ = StillStop{};
  open_.stop.index = stops_++;
  open_.stop.start_ns = start_ns_;
  open_.sensor = imu_sensor_;
  bins_ = 0.0;
  samples_ = 0.0;
  for (const MotionBin& bin : candidate_) extend_stop(bin);
  candidate_.clear();
}

void StillDetector::extend_stop(const MotionBin& bin) {
  if (bin.samples > 0) {
    bins_ += 1.0;
    samples_ += bin.samples;
    open_.acceleration_g += (bin.acceleration_mean - open_.acceleration_g) / bins_;
    open_.gyro_bias_rad_s += (bin.gyro_mean - open_.gyro_bias_rad_s) * (bin.samples / samples_);
  }
  open_.imu_gap = open_.imu_gap || bin.samples == 0;
  open_.stop.end_ns = bin.end_ns() - whole_ns_of_seconds(options_.margin_s) - 1;
  listener_.still_until(open_.stop.end_ns + 1, open_.stop.index);
}

void StillDetector::end_stop(StopEnd end) {
  const StillGyro gyro{open_.gyro_bias_rad_s, samples_, (open_.stop.start_ns + open_.stop.end_ns) / 2};
  if (open_.stop.index > 0) {
    const Turn turn = turn_.finish(gyro, judge_.noise_variance().sum() / 3.0, options_.gyro_scale_sigma);
    open_.R_previous_this = turn.R_previous_this;
    open_.rotation_sigma_rad = turn.sigma_rad;
    // So that what is no number is not known either.
    open_.rotation_known =
        turn.longest_interval_s <= options_.max_turn_gap_s && turn.sigma_rad <= options_.most_rotation_sigma_rad;
  }
  turn_.begin(gyro);
  not_still(still_end_ns_, DropReason::moving);
  open_.end = end;
  listener_.stop_ended(open_);
  state_ = State::moving;
}

void StillDetector::not_still(std::int64_t until_ns, DropReason reason) {
  listener_.not_still_until(until_ns,
                            stops_ == 0 && reason == DropReason::moving ? DropReason::before_first_stop : reason);
}

std::optional<RestNow> StillDetector::rest() const {
  if (state_ == State::moving) return std::nullopt;
  return RestNow{run_start_ns_, start_ns_, still_end_ns_, state_ == State::stopped ? open_.stop.index : -1};
}

StillFigures StillDetector::figures() const {
  StillFigures figures;
  figures.imu_samples = binner_.used();
  figures.imu_unusable = binner_.unusable();
  figures.imu_of_others = imu_of_others_;
  figures.stops = stops_;
  figures.longest_still_s = longest_still_s_;
  figures.brief_rests = brief_rests_.count();
  figures.longest_brief_rest_s = brief_rests_.longest_s();
  figures.gyro_noise_rad_s = judge_.lowest_noise_rad_s();
  figures.bias_changes = judge_.bias_changes();
  return figures;
}

}  // namespace rigcal
