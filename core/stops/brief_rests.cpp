#include "core/stops/brief_rests.h"

#include <algorithm>

#include "core/geometry/se3.h"

namespace rigcal {
namespace {

const double step_rad = to_rad(0.5);
const double least_turn_rad = to_rad(5.0);
constexpr double least_pause_s = 0.3;
constexpr double most_pause_s = 3.0;
constexpr double most_of_turn_rate = 0.2;

}  // namespace

void BriefRests::add(const MotionBin& bin, const Vector3d& gyro_bias_rad_s, bool in_stop) {
  // Nobody knows what the rig did while the unit was silent.
  if (bin.samples == 0 && !in_stop) {
    forget();
    return;
  }
  step_.turn_rad += bin.turn - bin.turn_s * gyro_bias_rad_s;
  step_.length_s += MotionBin::length_s;
  step_.in_stop = step_.in_stop || in_stop;
  if (step_.turn_rad.norm() > step_rad) end_step();
}

void BriefRests::end_step() {
  const Step step = step_;
  step_ = {};
  if (step.in_stop) {
    forget();
    return;
  }
  const double rate_rad_s = step.turn_rad.norm() / step.length_s;
  const bool turned = turned_rad_ >= least_turn_rad;
  const bool rests = step.length_s >= least_pause_s && step.length_s <= most_pause_s &&
                     rate_rad_s <= most_of_turn_rate * fastest_rad_s_;
  if (rests && (turned || pause_s_ > 0.0)) {
    // A wide swing makes several steps of one pause.
    pause_s_ += step.length_s;
    turned_rad_ = 0.0;
    return;
  }
  turned_rad_ += step.turn_rad.norm();
  fastest_rad_s_ = std::max(fastest_rad_s_, rate_rad_s);
  if (pause_s_ == 0.0 || turned_rad_ < least_turn_rad) return;
  ++count_;
  longest_s_ = std::max(longest_s_, pause_s_);
  pause_s_ = 0.0;
}

void BriefRests::forget() {
  step_ = {};
  turned_rad_ = fastest_rad_s_ = pause_s_ = 0.0;
}

}  // namespace rigcal
