#include "core/frames/release_line.h"

#include <algorithm>
#include <cmath>

#include "core/clocks/stamps.h"

namespace rigcal {
namespace {

constexpr double ppm = 1e-6;
constexpr double nanoseconds = 1e9;
constexpr double most_time = 4e18;      // Keeps what comes back within 64 bits.
constexpr double far_sigmas = 3.0;      // A stamp farther off counts as if its own error were that large.
constexpr double jitter_memory = 32.0;  // Frames over which the jitter is learnt.

double square(double value) { return value * value; }

}  // namespace

ReleaseLine::ReleaseLine(const StampNoise& noise, std::int64_t device_ns, std::int64_t pulse_ns)
    : noise_(noise),
      first_device_ns_(device_ns),
      first_pulse_ns_(pulse_ns),
      state_{0.0, 0.0, 0.0, square(noise.jitter_ns), 0.0, square(noise.drift_ppm * ppm)},
      jitter_variance_(square(noise.jitter_ns)) {}

ReleaseLine ReleaseLine::through(std::int64_t device_ns, std::int64_t pulse_ns) const {
  ReleaseLine line(noise_, device_ns, pulse_ns);
  line.state_.rate = state_.rate;
  line.state_.offset_variance = jitter_variance_;
  line.state_.rate_variance = state_.rate_variance;
  line.jitter_variance_ = jitter_variance_;
  return line;
}

ReleaseLine::State ReleaseLine::predicted(double time) const {
  State state = state_;
  const double step = time - state_.time;
  const double span = std::abs(step);
  const double wander = square(noise_.wander_ppm * ppm) / nanoseconds;  // Variance of the rate for each nanosecond.
  state.time = time;
  state.offset += step * state_.rate;
  state.offset_variance +=
      2.0 * step * state_.covariance + step * step * state_.rate_variance + wander * span * span * span / 3.0;
  state.covariance += step * state_.rate_variance + wander * step * span / 2.0;
  state.rate_variance += wander * span;
  return state;
}

StampEstimate ReleaseLine::at(std::int64_t device_ns) const {
  const auto time = static_cast<double>(stamp_difference(device_ns, first_device_ns_));
  const State state = predicted(time);
  const double since = std::clamp(time + state.offset, -most_time, most_time);
  return {stamp_sum(first_pulse_ns_, std::llround(since)),
          std::sqrt(std::max(0.0, state.offset_variance) + jitter_variance_)};
}

void ReleaseLine::add(std::int64_t device_ns, std::int64_t pulse_ns) {
  const auto time = static_cast<double>(stamp_difference(device_ns, first_device_ns_));
  State state = predicted(time);
  const double off = static_cast<double>(stamp_difference(pulse_ns, first_pulse_ns_)) - time - state.offset;
  const double expected = state.offset_variance + jitter_variance_;
  const double own = off * off > square(far_sigmas) * expected ? off * off / square(far_sigmas) : jitter_variance_;
  const double total = state.offset_variance + own;
  const double offset_gain = state.offset_variance / total;
  const double rate_gain = state.covariance / total;
  // What the line itself did not know is no jitter of the stamp.
  const double seen = std::min(off * off, square(far_sigmas) * expected) - state.offset_variance;
  state.offset += offset_gain * off;
  state.rate += rate_gain * off;
  state.rate_variance -= rate_gain * state.covariance;
  state.covariance -= offset_gain * state.covariance;
  state.offset_variance -= offset_gain * state.offset_variance;
  state_ = state;
  ++pairs_;
  const double share = 1.0 / std::min(static_cast<double>(pairs_), jitter_memory);
  jitter_variance_ = std::max(jitter_variance_ + share * (seen - jitter_variance_), square(noise_.least_jitter_ns));
}

double ReleaseLine::drift_ppm() const { return -state_.rate / (1.0 + state_.rate) / ppm; }

double ReleaseLine::jitter_ns() const { return std::sqrt(jitter_variance_); }

}  // namespace rigcal
