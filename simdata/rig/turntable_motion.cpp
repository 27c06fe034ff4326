#include "simdata/rig/turntable_motion.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "simdata/scene/random_vectors.h"

namespace rigcal::sim {
namespace {

constexpr std::uint64_t dwell_stream = 1;
constexpr std::uint64_t step_stream = 2;

// 10 s^3 - 15 s^4 + 6 s^5: from rest to rest without a jump in acceleration.
double s_curve(double s) {
  s = std::clamp(s, 0.0, 1.0);
  return s * s * s * (10.0 + s * (6.0 * s - 15.0));
}

// A point of a figure of eight (half its length 1), u from 0 to 2 pi from its crossing, and the way it runs there.
Vector3d eight(double u) { return {std::sin(u), 0.5 * std::sin(2.0 * u), 0.0}; }
double eight_heading(double u) { return std::atan2(std::cos(2.0 * u), std::cos(u)); }

}  // namespace

void let_wander(double off_m, double off_deg, TurntableOptions& options) {
  // The sigmas are of each of three directions.
  options.stop_jitter_m = off_m / std::sqrt(3.0);
  options.stop_jitter_deg = off_deg / std::sqrt(3.0);
}

TurntableMotion::TurntableMotion(const SE3& T_scene_table, const TurntableOptions& options, Random& random)
    : options_(options) {
  T_scene_axis_ = T_scene_table;
  T_scene_axis_.R = exp_so3(to_rad(options.axis_tilt_deg) * random_level_direction(random)) * T_scene_table.R;
  T_axis_base_.R = exp_so3(to_rad(options.base_tilt_deg) * random_level_direction(random));
  const double offset = random.uniform(options.base_offset_min, options.base_offset_max);
  T_axis_base_.t = offset * random_level_direction(random);
  // What only some runs have is drawn apart, and takes no number from the others, so that it changes nothing else.
  Random dwells(Random(random).next_u64(), dwell_stream);
  Random steps(Random(random).next_u64(), step_stream);
  double time = 0.0;
  double angle = 0.0;
  for (int k = 0; k < options.stops; ++k) {
    StopPose stop;
    stop.start_s = time;
    stop.angle = angle;
    stop.dwell_s = options.dwell_s;
    if (options.dwell_range_s) {
      const auto [shortest, longest] = *options.dwell_range_s;
      stop.dwell_s = shortest * std::pow(longest / shortest, dwells.uniform());
    }
    const double dwell = stop.dwell_s + (k == 0 ? options.initial_still_s : 0.0) +
                         (k + 1 == options.stops ? options.final_still_s : 0.0);
    stop.end_s = time + dwell;
    stop.jitter << to_rad(options.stop_jitter_deg) * random_normal3(random),
        options.stop_jitter_m * random_normal3(random);
    const Vector3d level = random_level_direction(random);
    const double size = options.swing_rad * random.uniform(0.5, 1.5);
    if (k > 0) stop.swing = size * (level + 0.5 * random.uniform(-1.0, 1.0) * Vector3d::UnitZ());
    stops_.push_back(stop);
    time = stop.end_s + options.turn_s + (options.overshoot_rad != 0.0 ? options.overshoot_return_s : 0.0);
    double step = 2.0 * pi / options.stops;
    if (options.drive_m > 0.0) {
      const double u = k * step;
      stops_.back().place = options.drive_m * eight(u);
      step = std::remainder(eight_heading(u + step) - eight_heading(u), 2.0 * pi);
    }
    step += to_rad(options.step_sigma_deg) * random.normal();
    if (options.step_range_deg) {
      const auto [least, most] = *options.step_range_deg;
      step = to_rad(steps.uniform(least, most));
    }
    angle += step;
  }
  for (std::size_t i = 0; i < options.bumps.size(); ++i) bump_axes_.push_back(random_direction(random));
  if (options.vibration.amplitude_rad != 0.0) {
    vibration_axis_ = random_direction(random);
    vibration_phase_ = random.uniform(0.0, 2.0 * pi);
  }
}

// The swing bends the whole carriage about the axis at the table's height; the jitter is the base's own.
SE3 TurntableMotion::compose(const Way& way, const Vector3d& bend_vector) const {
  const SE3 turn{exp_so3(way.angle * Vector3d::UnitZ()), way.place};
  const SE3 bend{exp_so3(bend_vector), Vector3d::Zero()};
  const SE3 off{exp_so3(way.jitter.head<3>()), way.jitter.tail<3>()};
  return T_scene_axis_ * turn * bend * T_axis_base_ * off;
}

Vector3d TurntableMotion::swing_at(double time_s) const {
  Vector3d swing = Vector3d::Zero();
  for (const StopPose& stop : stops_) {
    const double since = time_s - stop.start_s;
    if (since <= 0.0) break;
    if (since > 40.0 * options_.swing_decay_s) continue;
    // The last factor lets the swing begin without a jump in acceleration.
    const double rise = 1.0 - std::exp(-since * since / (0.05 * 0.05));
    swing +=
        stop.swing * rise * std::exp(-since / options_.swing_decay_s) * std::sin(2.0 * pi * options_.swing_hz * since);
  }
  return swing;
}

Vector3d TurntableMotion::bump_at(double time_s) const {
  Vector3d lean = Vector3d::Zero();
  for (std::size_t i = 0; i < options_.bumps.size(); ++i) {
    const Bump& bump = options_.bumps[i];
    if (bump.stop < 0 || bump.stop >= stop_count()) continue;
    const double begin = stop_start_s(bump.stop) + bump.time_s;
    const double there =
        s_curve((time_s - begin) / bump_s) - s_curve((time_s - stop_end_s(bump.stop)) / options_.turn_s);
    lean += std::max(0.0, there) * bump.angle_rad * bump_axes_[i];
  }
  return lean;
}

Vector3d TurntableMotion::vibration_at(double time_s) const {
  const double phase = 2.0 * pi * options_.vibration.frequency_hz * time_s + vibration_phase_;
  return options_.vibration.amplitude_rad * std::sin(phase) * vibration_axis_;
}

TurntableMotion::Way TurntableMotion::way_at(double time_s) const {
  const auto after = std::upper_bound(stops_.begin(), stops_.end(), time_s,
                                      [](double time, const StopPose& stop) { return time < stop.start_s; });
  const StopPose& stop = after == stops_.begin() ? stops_.front() : *(after - 1);
  const double crept = options_.creep_rad_per_s * time_s;
  if (time_s <= stop.end_s || after == stops_.end()) return {stop.angle + crept, stop.place, stop.jitter};
  const double since = time_s - stop.end_s;
  const double s = s_curve(since / options_.turn_s);
  const double back =
      options_.overshoot_rad != 0.0 ? s_curve((since - options_.turn_s) / options_.overshoot_return_s) : 0.0;
  const double angle = stop.angle + s * (after->angle - stop.angle) + (s - back) * options_.overshoot_rad;
  return {angle + crept, stop.place + s * (after->place - stop.place), stop.jitter + s * (after->jitter - stop.jitter)};
}

SE3 TurntableMotion::pose_at(double time_s, const Vector3d& bend) const { return compose(way_at(time_s), bend); }

double TurntableMotion::angle_rad(double time_s) const { return way_at(time_s).angle - stops_.front().angle; }

SE3 TurntableMotion::T_scene_base(double time_s) const {
  Vector3d bend = swing_at(time_s);
  if (moves_at_rest()) bend += bump_at(time_s) + vibration_at(time_s);
  return pose_at(time_s, bend);
}

SE3 TurntableMotion::T_scene_base_at_stop(int k) const {
  return T_scene_base_settled(0.5 * (stop_start_s(k) + stop_end_s(k)));
}

std::vector<Rest> TurntableMotion::rests() const {
  std::vector<Bump> bumps = options_.bumps;
  std::stable_sort(bumps.begin(), bumps.end(), [](const Bump& a, const Bump& b) { return a.time_s < b.time_s; });
  std::vector<Rest> rests;
  for (int k = 0; k < stop_count(); ++k) {
    double start = stop_start_s(k);
    for (const Bump& bump : bumps) {
      const double at = stop_start_s(k) + bump.time_s;
      if (bump.stop != k || at >= stop_end_s(k)) continue;
      if (at > start) rests.push_back({k, start, at});
      start = std::max(start, std::min(at + bump_s, stop_end_s(k)));
    }
    if (start < stop_end_s(k)) rests.push_back({k, start, stop_end_s(k)});
  }
  return rests;
}

SE3 TurntableMotion::T_G_base_at_stop(int k) const { return T_scene_G().inverse() * T_scene_base_at_stop(k); }

Vector3d TurntableMotion::axis_in_base() const { return T_axis_base_.R.transpose() * Vector3d::UnitZ(); }

Vector3d TurntableMotion::axis_point_in_base() const {
  const Vector3d on_axis = T_axis_base_.inverse() * Vector3d(0.0, 0.0, 0.0);
  const Vector3d axis = axis_in_base();
  return on_axis - on_axis.dot(axis) * axis;
}

}  // namespace rigcal::sim
