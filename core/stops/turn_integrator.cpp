#include "core/stops/turn_integrator.h"

#include <algorithm>
#include <cmath>

#include "core/base/seconds.h"

namespace rigcal {

void TurnIntegrator::begin(const StillGyro& from) {
  *this = TurnIntegrator{};
  from_ = from;
}

void TurnIntegrator::add(const MotionBin& bin) {
  const Vector3d phi = bin.turn - from_.bias_rad_s * bin.turn_s;
  const Matrix3d step = exp_so3(phi);
  const double since_s = seconds_of_ns(bin.start_ns + MotionBin::length_ns / 2 - from_.middle_ns);
  // The right Jacobian is the left one of -phi.
  derivative_ = step.transpose() * derivative_ - left_jacobian_so3(-phi) * (bin.turn_s * since_s);
  R_ = R_ * step;
  angle_ += phi.norm();
  length_s_ += bin.turn_s;
  if (bin.samples > 0) interval2_sum_ += bin.turn_s * bin.turn_s / bin.samples;
  longest_interval_s_ = std::max(longest_interval_s_, bin.longest_interval_s);
}

Turn TurnIntegrator::finish(const StillGyro& to, double noise_variance, double scale_sigma) const {
  const double between_s = seconds_of_ns(to.middle_ns - from_.middle_ns);
  const Vector3d slope = (to.bias_rad_s - from_.bias_rad_s) / between_s;
  Turn turn;
  turn.R_previous_this = nearest_rotation(R_ * exp_so3(derivative_ * slope));
  // Noise on the way, the two biases (each about half of the way), the scale over the whole path.
  const double bias_variance = noise_variance * 0.25 * (1.0 / from_.samples + 1.0 / to.samples);
  turn.sigma_rad = std::sqrt(noise_variance * interval2_sum_ + bias_variance * length_s_ * length_s_ +
                             scale_sigma * scale_sigma * angle_ * angle_);
  turn.longest_interval_s = longest_interval_s_;
  return turn;
}

}  // namespace rigcal
