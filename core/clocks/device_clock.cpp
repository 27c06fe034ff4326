#include "core/clocks/device_clock.h"

#include <algorithm>
#include <cmath>

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr double kMillisecond = 1e6;
constexpr double kSecond = 1e9;
constexpr double kEarlyJump = 20.0 * kMillisecond;
// While the line is young it may stand on packets of one burst, which come up to about 100 ms late.
constexpr double kYoung = kSecond;
constexpr double kYoungEarlyJump = 200.0 * kMillisecond;
constexpr double kLateJump = kSecond;
constexpr double kBackwards = 50.0 * kMillisecond;  // Streams of a device are a few milliseconds apart.
constexpr double kDriftAllowance = 500e-6;
constexpr int kStraysOfJump = 5;
constexpr double kStraysAgree = 100.0 * kMillisecond;
constexpr double kLateShift = 5.0 * kMillisecond;
constexpr double kSteerTime = 0.1 * kSecond;
constexpr double kSteerRate = 0.2;
constexpr double kSteerLimit = 100.0 * kMillisecond;

}  // namespace

double DeviceClock::Course::at(double time) const {
  return offset + rate * (std::min(time, end) - start) + slope * std::max(0.0, time - end);
}

void DeviceClock::start(std::int64_t device_ns, std::int64_t received_ns) {
  started_ = true;
  strays_in_row_ = 0;
  origin_device_ns_ = device_ns;
  origin_offset_ns_ = stamp_difference(received_ns, device_ns);
  latest_ = 0.0;
  line_.restart(0.0, 0.0);
  course_ = {0.0, 0.0, line_.slope(), 0.0, line_.slope()};
}

bool DeviceClock::is_stray(double time, double offset) const {
  const double height = offset - line_.at(time);
  const double allowance = kDriftAllowance * std::abs(time - latest_);
  const double early = line_.age(latest_) < kYoung ? kYoungEarlyJump : kEarlyJump;
  return height < -(early + allowance) || height > kLateJump + allowance || time < latest_ - kBackwards;
}

SessionStamp DeviceClock::add_stray(double offset, std::int64_t device_ns, std::int64_t received_ns) {
  if (strays_in_row_ == 0 || std::abs(offset - stray_offset_) > kStraysAgree) {
    strays_in_row_ = 0;
    stray_offset_ = offset;
  }
  ++strays_in_row_;
  if (strays_in_row_ < kStraysOfJump) {
    ++figures_.strays;
    return {received_ns, true, false};
  }
  figures_.strays -= kStraysOfJump - 1;  // They were the first packets after the jump.
  ++figures_.jumps;
  start(device_ns, received_ns);
  return {received_ns, false, true};
}

SessionStamp DeviceClock::add(std::int64_t device_ns, std::int64_t received_ns) {
  ++figures_.packets;
  if (!started_) {
    start(device_ns, received_ns);
    return {received_ns, false, false};
  }
  const auto time = static_cast<double>(stamp_difference(device_ns, origin_device_ns_));
  const auto offset =
      static_cast<double>(stamp_difference(stamp_difference(received_ns, device_ns), origin_offset_ns_));
  if (is_stray(time, offset)) return add_stray(offset, device_ns, received_ns);
  strays_in_row_ = 0;
  const bool moved = line_.add(time, offset);
  latest_ = std::max(latest_, time);
  if (moved) {
    mend_late_shift();
    steer();
  }
  const double used = course_.at(time);
  count_delay(offset - used);
  const std::int64_t offset_ns = stamp_sum(origin_offset_ns_, std::llround(used));
  return {stamp_sum(device_ns, offset_ns), false, false};
}

void DeviceClock::mend_late_shift() {
  const double height = line_.recent_height();
  if (height < kLateShift) return;
  line_.keep_recent();
  if (height > kEarlyJump) ++figures_.jumps;
}

void DeviceClock::steer() {
  const double current = course_.at(latest_);
  const double target = line_.at(latest_ + kSteerTime);
  const double slope = line_.slope();
  if (std::abs(target - current) > kSteerLimit) {
    course_ = {latest_, line_.at(latest_), slope, latest_, slope};
    return;
  }
  const double rate = std::clamp((target - current) / kSteerTime, slope - kSteerRate, slope + kSteerRate);
  course_ = {latest_, current, rate, latest_ + kSteerTime, slope};
}

void DeviceClock::count_delay(double delay) {
  delay_sum_ += delay;
  delay_square_sum_ += delay * delay;
  figures_.max_delay_ns = std::max(figures_.max_delay_ns, delay);
}

ClockFigures DeviceClock::figures() const {
  ClockFigures figures = figures_;
  const auto mapped = static_cast<double>(figures.packets - figures.strays);
  figures.drift_ppm = -1e6 * line_.slope() / (1.0 + line_.slope());
  if (mapped > 0.0) {
    figures.mean_delay_ns = delay_sum_ / mapped;
    const double variance = delay_square_sum_ / mapped - figures.mean_delay_ns * figures.mean_delay_ns;
    figures.jitter_ns = std::sqrt(std::max(0.0, variance));
  }
  return figures;
}

}  // namespace rigcal
