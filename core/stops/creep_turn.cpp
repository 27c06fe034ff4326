#include "core/stops/creep_turn.h"

#include <cmath>

#include "core/base/seconds.h"

namespace rigcal {

void CreepTurn::add(const StillStop& rest) {
  if (rest.stop.start_ns < begin_ns_ || rest.stop.start_ns >= end_ns_) return;
  any_rest_ = true;
  if (!rest.rotation_known) {
    has_hole_ = true;
    return;
  }
  turns_rad_.try_emplace(rest.sensor, Vector3d::Zero()).first->second += log_so3(rest.R_previous_this);
  variance_ += rest.rotation_sigma_rad * rest.rotation_sigma_rad;
}

void CreepTurn::put_before(StillStop& next) const {
  Vector3d sum = Vector3d::Zero();
  double variance = next.rotation_sigma_rad * next.rotation_sigma_rad + variance_;
  const auto axis_here = options_.turn_axes.find(next.sensor);
  for (const auto& [sensor, turn] : turns_rad_) {
    const auto axis_there = options_.turn_axes.find(sensor);
    if (sensor == next.sensor) {
      sum += turn;
    } else if (axis_here != options_.turn_axes.end() && axis_there != options_.turn_axes.end()) {
      sum += axis_there->second.dot(turn) * axis_here->second;
    } else {
      variance += turn.squaredNorm();
    }
  }
  if (has_hole_ || !any_rest_) {
    const double most = options_.creep_limit_rad_s * seconds_of_ns(end_ns_ - begin_ns_);
    variance += most * most;
  }
  next.R_previous_this = nearest_rotation(exp_so3(sum) * next.R_previous_this);
  next.rotation_sigma_rad = std::sqrt(variance);
}

}  // namespace rigcal
