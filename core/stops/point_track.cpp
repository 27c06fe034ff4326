#include "core/stops/point_track.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

// What no surface holds is held by this; loose against all that points can tell.
constexpr double loose_rad = to_rad(2.0);
constexpr double loose_m = 0.05;
// A shift that matters as little as the angle limit does: a fiftieth of the range noise.
constexpr double harmless_m = 3e-4;
constexpr double fewest_met = 30.0;
constexpr int kept_steps = 5;
// Shares of the reference's own.
constexpr double least_met = 0.4;
constexpr double least_inside = 0.6;
constexpr std::int64_t resolution_slots = 10;
constexpr double trembles = 1.5;
constexpr double tremble_noise_rad = to_rad(0.05);
// Square of the difference of a window's halves over its noise, six degrees of freedom: 1 % of rests are above.
constexpr double most_half_change = 17.0;

const Matrix6d& loose() {
  static const Matrix6d prior = [] {
    Vector6d diagonal;
    diagonal << Vector3d::Constant(1.0 / (loose_rad * loose_rad)), Vector3d::Constant(1.0 / (loose_m * loose_m));
    return Matrix6d(diagonal.asDiagonal());
  }();
  return prior;
}

Matrix6d covariance_of(const RangeMotion& motion) {
  return Matrix6d((motion.information + loose()).llt().solve(Matrix6d::Identity()));
}

/// The share of the six directions that the points decide, summed.
double freedom_of(const Matrix6d& covariance) { return 6.0 - (covariance * loose()).trace(); }

}  // namespace

PointTrack::PointTrack(std::size_t lidar, int sensor, const StopOptions& options) : lidar_(lidar), options_(options) {
  if (const auto axis = options.turn_axes.find(sensor); axis != options.turn_axes.end()) axis_ = axis->second;
}

void PointTrack::take_reference(const PointSlots& slots, std::int64_t first, std::int64_t last) {
  std::vector<std::span<const RangePoint>> pieces;
  for (std::int64_t slot = first; slot <= last; ++slot) pieces.push_back(slots.points(lidar_, slot));
  reference_.build(pieces);
  for (std::int64_t slot = first; slot <= last; ++slot) measure(slots, slot);
  reference_motion_ = sum(first, last);
  reference_covariance_ = covariance_of(reference_motion_);
  reference_slots_ = last - first + 1;
}

void PointTrack::measure(const PointSlots& slots, std::int64_t slot) {
  motions_[static_cast<std::size_t>(slot % PointSlots::kept)] = reference_.measure(slots.points(lidar_, slot));
}

RangeMotion PointTrack::sum(std::int64_t first, std::int64_t last) const {
  RangeMotion motion;
  for (std::int64_t slot = first; slot <= last; ++slot) motion += at(slot);
  return motion;
}

double PointTrack::offness(std::int64_t first, std::int64_t last) const {
  const RangeMotion motion = sum(first, last);
  const RangeMotion& usual = reference_motion_;
  if (motion.points < fewest_met || usual.met < fewest_met) return 0.0;
  if (motion.met * usual.points < least_met * usual.met * motion.points ||
      motion.inside * usual.met < least_inside * usual.inside * motion.met) {
    return std::numeric_limits<double>::infinity();
  }
  const Matrix6d own = covariance_of(motion);
  const Vector6d xi = own * motion.right;
  const double limit = options_.angle_limit_rad;
  Vector6d harmless;
  harmless << Vector3d::Constant(limit * limit), Vector3d::Constant(harmless_m * harmless_m);
  Matrix6d covariance = noise_ratio_ * (own + reference_covariance_);
  covariance.diagonal() += harmless / most_offness;
  return xi.dot(covariance.llt().solve(xi));
}

PointTrack::Scatter PointTrack::scatter(std::int64_t first, std::int64_t last) const {
  Scatter result;
  // Trembling is looked for about the axes that are seen well.
  const SymmetricEigen axes = symmetric_eigen(reference_covariance_.topLeftCorner<3, 3>());
  double change = 0.0;
  double change_freedom = 0.0;
  double energy = 0.0;
  double energy_freedom = 0.0;
  std::array<double, 2> half_energy = {0.0, 0.0};
  Vector3d turn2 = Vector3d::Zero();
  Vector3d turn2_noise = Vector3d::Zero();
  double slots = 0.0;
  Vector6d before = Vector6d::Zero();
  Matrix6d covariance_before = Matrix6d::Zero();
  bool has_before = false;
  for (std::int64_t slot = first; slot <= last; ++slot) {
    const RangeMotion& motion = at(slot);
    if (motion.met < fewest_met) {
      has_before = false;
      continue;
    }
    const Matrix6d covariance = covariance_of(motion);
    const double freedom = freedom_of(covariance);
    const Vector6d xi = covariance * motion.right;
    energy += xi.dot(motion.right);
    energy_freedom += freedom;
    half_energy[2 * (slot - first) < last - first + 1 ? 0 : 1] += xi.dot(motion.right);
    turn2 += (axes.vectors.transpose() * xi.head<3>()).cwiseAbs2();
    turn2_noise += (axes.vectors.transpose() * covariance.topLeftCorner<3, 3>() * axes.vectors).diagonal();
    slots += 1.0;
    if (has_before) {
      const Vector6d step = xi - before;
      change += step.dot((covariance + covariance_before).llt().solve(step));
      change_freedom += freedom;
    }
    before = xi;
    covariance_before = covariance;
    has_before = true;
  }
  if (change_freedom < 1.0) return result;
  result.noise_ratio = change / change_freedom;
  const double less = std::min(half_energy[0], half_energy[1]);
  result.half_ratio = less > 0.0 ? std::max(half_energy[0], half_energy[1]) / less : 1.0;
  double tremble2 = 0.0;
  for (int i = 0; i < 3; ++i) {
    const double noise2 = turn2_noise[i] / slots;
    if (noise2 < tremble_noise_rad * tremble_noise_rad) {
      tremble2 += std::max(0.0, turn2[i] / slots - noise2 * std::max(1.0, result.noise_ratio));
    }
  }
  result.tremble_rad = std::sqrt(tremble2);
  // A slow trembling changes little from slot to slot; a drift changes from half to half.
  const std::int64_t middle = first + (last - first + 1) / 2;
  const double ratio = energy / energy_freedom;
  if (ratio > result.noise_ratio && half_change(first, middle, last) < most_half_change * ratio) {
    // It often is about one axis of the six directions over which the ratio is a mean, and stays off for some slots.
    result.noise_ratio = ratio > trembles * result.noise_ratio ? 2.0 * ratio : ratio;
  }
  return result;
}

double PointTrack::half_change(std::int64_t first, std::int64_t middle, std::int64_t last) const {
  const RangeMotion earlier = sum(first, middle - 1);
  const RangeMotion later = sum(middle, last);
  const Matrix6d a = covariance_of(earlier);
  const Matrix6d b = covariance_of(later);
  const Vector6d step = b * later.right - a * earlier.right;
  return step.dot(Matrix6d(a + b).llt().solve(step));
}

double PointTrack::resolution_of(double turn_variance, double slots) const {
  const double all = static_cast<double>(reference_slots_);
  return std::sqrt(most_offness * noise_ratio_ * turn_variance * (all / slots + 1.0));
}

double PointTrack::resolution_rad() const {
  if (reference_slots_ == 0) return std::numeric_limits<double>::infinity();
  if (!axis_) return worst_resolution_rad(resolution_slots);
  return resolution_of(axis_->dot(reference_covariance_.topLeftCorner<3, 3>() * *axis_), resolution_slots);
}

double PointTrack::worst_resolution_rad(std::int64_t slots) const {
  const Matrix3d turn = reference_covariance_.topLeftCorner<3, 3>();
  return resolution_of(symmetric_eigen(turn).values[2], static_cast<double>(slots));
}

Vector3d PointTrack::turn(std::int64_t first, std::int64_t last) const {
  const RangeMotion motion = sum(first, last);
  return (covariance_of(motion) * motion.right).head<3>();
}

Vector3d PointTrack::slot_variance() const {
  return noise_ratio_ * static_cast<double>(reference_slots_) * reference_covariance_.diagonal().head<3>();
}

void PointTrack::keep_reference() { kept_ = reference_; }

std::optional<Vector3d> PointTrack::turn_from_kept(const PointSlots& slots, std::int64_t first,
                                                   std::int64_t last) const {
  if (!kept_) return std::nullopt;
  SE3 T_kept_now;
  std::vector<RangePoint> moved;
  for (int step = 0;; ++step) {
    RangeMotion motion;
    for (std::int64_t slot = first; slot <= last; ++slot) {
      moved.clear();
      for (const RangePoint& point : slots.points(lidar_, slot)) moved.push_back(transformed(T_kept_now, point));
      motion += kept_->measure(moved);
    }
    if (step == kept_steps) {
      const bool same = motion.met * reference_motion_.points > least_met * reference_motion_.met * motion.points &&
                        motion.inside * reference_motion_.met > least_inside * reference_motion_.inside * motion.met;
      return same ? std::optional<Vector3d>(log_so3(T_kept_now.R)) : std::nullopt;
    }
    const Vector6d xi = covariance_of(motion) * motion.right;
    T_kept_now = SE3{exp_so3(xi.head<3>()), xi.tail<3>()} * T_kept_now;
  }
}

}  // namespace rigcal
