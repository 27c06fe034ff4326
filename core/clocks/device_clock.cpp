#include "core/clocks/device_clock.h"

#include <algorithm>
#include <cmath>

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr double millisecond = 1e6;
constexpr double second = 1e9;
constexpr double early_jump_ns = 20.0 * millisecond;
// While the line is young it may stand on packets of one burst, which come up to about 100 ms late.
constexpr double young_ns = second;
constexpr double young_early_jump_ns = 200.0 * millisecond;
constexpr double late_jump_ns = second;
constexpr double backwards_ns = 50.0 * millisecond;  // Streams of a device are a few milliseconds apart.
constexpr double drift_allowance = 500e-6;
constexpr int strays_of_jump = 5;
constexpr double strays_agree_ns = 100.0 * millisecond;
constexpr double late_shift_ns = 5.0 * millisecond;
constexpr double steer_time_ns = 0.1 * second;
constexpr double steer_rate = 0.2;
constexpr double steer_limit_ns = 100.0 * millisecond;

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
  const double allowance = drift_allowance * std::abs(time - latest_);
  const double early = line_.age(latest_) < young_ns ? young_early_jump_ns : early_jump_ns;
  return height < -(early + allowance) || height > late_jump_ns + allowance || time < latest_ - backwards_ns;
}

SessionStamp DeviceClock::add_stray(double offset, std::int64_t device_ns, std::int64_t received_ns) {
  if (strays_in_row_ == 0 || std::abs(offset - stray_offset_) > strays_agree_ns) {
    strays_in_row_ = 0;
    stray_offset_ = offset;
  }
  ++strays_in_row_;
  if (strays_in_row_ < strays_of_jump) {
    ++figures_.strays;
    return {received_ns, true, false};
  }
  figures_.strays -= strays_of_jump - 1;  // They were the first packets after the jump.
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
  bool stepped = false;
  if (moved) {
    const bool shifted = mend_late_shift();
    stepped = steer();
    if (shifted || stepped) ++figures_.jumps;
  }
  const double used = course_.at(time);
  count_delay(offset - used);
  const std::int64_t offset_ns = stamp_sum(origin_offset_ns_, std::llround(used));
  return {stamp_sum(device_ns, offset_ns), false, stepped};
}

// Whether by as much as a clock that was set.
bool DeviceClock::mend_late_shift() {
  const double height = line_.recent_height();
  if (height < late_shift_ns) return false;
  line_.keep_recent();
  return height > early_jump_ns;
}

// Whether the course stepped.
bool DeviceClock::steer() {
  const double current = course_.at(latest_);
  const double target = line_.at(latest_ + steer_time_ns);
  const double slope = line_.slope();
  if (std::abs(target - current) > steer_limit_ns) {
    course_ = {latest_, line_.at(latest_), slope, latest_, slope};
    return true;
  }
  const double rate = std::clamp((target - current) / steer_time_ns, slope - steer_rate, slope + steer_rate);
  course_ = {latest_, current, rate, latest_ + steer_time_ns, slope};
  return false;
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
