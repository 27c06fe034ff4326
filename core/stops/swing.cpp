#include "core/stops/swing.h"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "core/base/seconds.h"

namespace rigcal {
namespace {

// What rigs on tables and tripods do, with room at both ends; 25 ms bins show up to 15 Hz well.
constexpr std::array<double, 7> decays_s = {0.05, 0.09, 0.15, 0.25, 0.4, 0.7, 1.2};
constexpr double lowest_hz = 1.5;  // slower ones can not be told from creep that ends
constexpr double step_hz = 0.5;
constexpr int refinements = 24;    // halvings and moves of a pattern search: to a thousandth of the first step
constexpr std::size_t stride = 4;  // bins by which a fit reaches further back than the last
constexpr std::size_t fewest_bins = 12;
constexpr double residual_sigmas = 6.0;
constexpr double model_share = 0.01;  // of the energy that a swing which is not quite a damped sine may leave

/// The damped cosine and sine (real and imaginary part) bin by bin: powers of one complex number.
class DampedWave {
 public:
  DampedWave(double hz, double decay_s)
      : step_(std::polar(std::exp(-MotionBin::length_s / decay_s), 2.0 * pi * hz * MotionBin::length_s)) {}

  Eigen::Vector2d at(std::size_t bins_since_start) {
    for (; bin_ < bins_since_start; ++bin_) value_ *= step_;
    return {value_.real(), value_.imag()};
  }

 private:
  std::complex<double> step_;
  std::complex<double> value_ = 1.0;
  std::size_t bin_ = 0;
};

SwingFit fit_amplitudes(std::span<const SwingReading> readings, double hz, double decay_s) {
  Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
  Eigen::Matrix<double, 2, 3> right = Eigen::Matrix<double, 2, 3>::Zero();
  DampedWave wave(hz, decay_s);
  for (const SwingReading& r : readings) {
    const Eigen::Vector2d g = wave.at(r.bin - readings.front().bin);
    normal += r.weight * g * g.transpose();
    right += (r.weight * g) * r.value.transpose();
  }
  SwingFit fit{hz, decay_s, 0.0, {}, readings.front().bin};
  fit.amplitudes = normal.inverse() * right;
  fit.explained = fit.amplitudes.cwiseProduct(right).sum();
  if (!std::isfinite(fit.explained)) fit.explained = 0.0;
  return fit;
}

SwingFit refine(std::span<const SwingReading> readings, SwingFit best, const SwingLimits& limits) {
  double hz_step = 0.5 * step_hz;
  double ratio = 1.3;
  for (int i = 0; i < refinements; ++i) {
    const double hz = best.hz;
    const double decay_s = best.decay_s;
    bool better = false;
    for (const auto& [h, d] : {std::pair(hz + hz_step, decay_s), std::pair(hz - hz_step, decay_s),
                               std::pair(hz, decay_s * ratio), std::pair(hz, decay_s / ratio)}) {
      if (h < 0.8 * lowest_hz || h * d < limits.least_cycles || d > 2.0 * decays_s.back() || d < 0.5 * decays_s.front())
        continue;
      const SwingFit fit = fit_amplitudes(readings, h, d);
      if (fit.explained <= best.explained) continue;
      best = fit;
      better = true;
    }
    if (better) continue;
    hz_step *= 0.5;
    ratio = std::sqrt(ratio);
  }
  return best;
}

SwingFit search(std::span<const SwingReading> readings, const SwingLimits& limits) {
  SwingFit best;
  for (const double decay_s : decays_s) {
    for (double hz = lowest_hz; hz <= limits.highest_hz; hz += step_hz) {
      if (hz * decay_s < limits.least_cycles) continue;
      const SwingFit fit = fit_amplitudes(readings, hz, decay_s);
      if (fit.explained > best.explained) best = fit;
    }
  }
  return best.explained > 0.0 ? refine(readings, best, limits) : best;
}

// Whether the fit leaves but noise, in all, without the oldest bins and in the later half: else it is a motion's end
// that it describes.
bool explains(const SwingFit& fit, std::span<const SwingReading> readings) {
  for (const std::size_t from : {std::size_t{0}, stride, readings.size() / 2}) {
    double left = 0.0;
    double energy = 0.0;
    DampedWave wave(fit.hz, fit.decay_s);
    for (const SwingReading& r : readings.subspan(from)) {
      const Vector3d model = fit.amplitudes.transpose() * wave.at(r.bin - readings.front().bin);
      left += r.weight * (r.value - model).squaredNorm();
      energy += r.weight * r.value.squaredNorm();
    }
    const double freedom = 3.0 * static_cast<double>(readings.size() - from);
    if (left > freedom + residual_sigmas * std::sqrt(2.0 * freedom) + model_share * energy) return false;
  }
  return true;
}

}  // namespace

std::optional<SwingFit> fit_swing(std::span<const SwingReading> readings, std::size_t still_from,
                                  const SwingLimits& limits) {
  if (readings.size() < fewest_bins) return std::nullopt;
  std::optional<SwingFit> found;
  for (std::size_t from = std::min(still_from, readings.size() - fewest_bins);; from -= stride) {
    const std::span<const SwingReading> part = readings.subspan(from);
    // The swing of the bins seen so far goes on, as a rule.
    SwingFit fit;
    if (found) fit = refine(part, fit_amplitudes(part, found->hz, found->decay_s), limits);
    if (!found || !explains(fit, part)) fit = search(part, limits);
    if (!explains(fit, part)) break;
    if (fit.explained >= limits.least_explained) found = fit;
    if (from < stride) break;
  }
  return found;
}

double fading_s(const SwingFit& fit, double amplitude, double limit) {
  return fit.decay_s * std::log(amplitude / limit) + 0.5 * MotionBin::length_s;
}

std::int64_t swing_settled_ns(std::span<const MotionBin> bins, std::size_t first_still, const Vector3d& gyro_bias,
                              const Vector3d& noise_variance, double angle_limit_rad) {
  constexpr std::int64_t never_seen = std::numeric_limits<std::int64_t>::min();
  const Vector3d noise = noise_variance.cwiseSqrt();
  std::vector<SwingReading> readings;
  std::size_t still_from = 0;
  for (std::size_t i = 0; i < bins.size(); ++i) {
    if (i == first_still) still_from = readings.size();
    if (bins[i].samples == 0) continue;
    readings.push_back({i, static_cast<double>(bins[i].samples), (bins[i].gyro_mean - gyro_bias).cwiseQuotient(noise)});
  }
  const std::optional<SwingFit> found = fit_swing(readings, still_from, {});
  if (!found) return never_seen;

  // From the rate's amplitude, averaged over bins, to the angle's.
  const double omega = 2.0 * pi * found->hz;
  const double x = 0.5 * omega * MotionBin::length_s;
  const double rate = (noise.asDiagonal() * found->amplitudes.transpose()).norm() * x / std::sin(std::min(x, 1.5));
  const double angle = rate / std::hypot(omega, 1.0 / found->decay_s);
  if (!(angle > 0.0)) return never_seen;
  return bins[found->start_bin].start_ns + whole_ns_of_seconds(fading_s(*found, angle, angle_limit_rad));
}

}  // namespace rigcal
