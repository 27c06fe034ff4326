#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>

#include "core/base/parallel.h"
#include "core/planes/merge_planes.h"
#include "core/planes/refine.h"
#include "core/quality/inverse_information.h"
#include "core/quality/lidar_quality.h"

namespace rigcal {
namespace {

// Fewer offsets of what was held out say nothing.
constexpr double least_offsets = 6.0;

// Every fourth of some stops, or with fewer than four of them every fifth plane.
class EveryFourth {
 public:
  // Of the stops in which any LiDAR saw something, or one.
  EveryFourth(const SolvedPlanes& solved, std::optional<int> lidar)
      : place_(static_cast<std::size_t>(solved.layout.stops()), -1) {
    for (const PlaneFeature& feature : solved.features) {
      for (const PlaneObservation& o : feature.observations) {
        if (!lidar || o.lidar == *lidar) place_[static_cast<std::size_t>(o.stop)] = 0;
      }
    }
    for (int& place : place_) {
      if (place == 0) place = stops_++;
    }
  }

  [[nodiscard]] bool goes_by_stops() const { return stops_ >= 4; }
  [[nodiscard]] bool holds_out(std::size_t feature, int stop) const {
    return goes_by_stops() ? place_[static_cast<std::size_t>(stop)] % 4 == 2 : feature % 5 == 2;
  }

 private:
  std::vector<int> place_;  ///< Of each stop among these; -1: it is not.
  int stops_ = 0;
};

// Who is held out: all LiDARs but the base by the stops that any saw, some by their own.
class HeldOut {
 public:
  HeldOut(const SolvedPlanes& solved, int base)
      : base_(base), all_(solved, std::nullopt), own_(static_cast<std::size_t>(solved.layout.lidars())) {}

  void go_by_own_stops(const SolvedPlanes& solved, int lidar) {
    own_[static_cast<std::size_t>(lidar)].emplace(solved, lidar);
  }

  [[nodiscard]] bool goes_by_stops() const { return all_.goes_by_stops(); }
  // Of all or of one.
  [[nodiscard]] bool goes_by_planes() const {
    return !all_.goes_by_stops() || std::any_of(own_.begin(), own_.end(), [](const std::optional<EveryFourth>& own) {
      return own && !own->goes_by_stops();
    });
  }
  [[nodiscard]] bool operator()(std::size_t feature, const PlaneObservation& o) const {
    if (o.lidar == base_) return false;
    const std::optional<EveryFourth>& own = own_[static_cast<std::size_t>(o.lidar)];
    return (own ? *own : all_).holds_out(feature, o.stop);
  }

 private:
  int base_;
  EveryFourth all_;
  std::vector<std::optional<EveryFourth>> own_;
};

// Of what an observation is off its plane by, from how well poses and extrinsics are known (`C`, of all that is free):
// a stop that only the base placed may be loose along what the base does not face.
double pose_variance(const SolvedPlanes& solved, const Eigen::MatrixXd& C, const RigState& state,
                     const PlaneObservation& o, const Vector3d& normal) {
  const SE3& T_base_sensor = state.T_base_sensor[static_cast<std::size_t>(o.lidar)];
  const auto along = [&](const Vector3d& p, const Matrix3d& R) {
    const Vector3d n = R.transpose() * normal;
    Vector6d J;
    J << p.cross(n), n;
    return J;
  };
  const Matrix3d& R_G_base = state.T_G_base[static_cast<std::size_t>(o.stop)].R;
  const std::array<Vector6d, 2> J{along(T_base_sensor * o.mean, R_G_base), along(o.mean, R_G_base * T_base_sensor.R)};
  const std::array<int, 2> at{solved.layout.stop_index(o.stop), solved.layout.lidar_index(o.lidar)};
  double variance = 0.0;
  for (std::size_t a = 0; a < 2; ++a) {
    for (std::size_t b = 0; b < 2; ++b) {
      if (at[a] >= 0 && at[b] >= 0) variance += J[a].dot(C.block<6, 6>(at[a], at[b]) * J[b]);
    }
  }
  return std::max(0.0, variance);
}

// Of poses and extrinsics by some of the planes.
Eigen::MatrixXd covariance_by(const std::vector<PlaneFeature>& features, const SolvedPlanes& solved,
                              const RigState& state) {
  if (solved.layout.size() == 0) return {};
  NormalEquations sum = build_normal_equations(features, state, solved.layout, HessianForm::gauss_newton);
  add_priors(solved.layout, solved.adjust, state, sum);
  return 2.0 * inverse_information(sum.H);
}

// As the last pass over the surfaces does; whether it trusted the noise is not known here.
void merge_anew(std::vector<PlaneFeature>& leaves) {
  MergeOptions options;
  options.tolerance_m = RefinePass{}.merge_tolerance_m;
  std::vector<PlaneFeature> merged = merge_coplanar(leaves, options);
  std::move(merged.begin(), merged.end(), std::back_inserter(leaves));
}

// The planes by what is left of them without what is held out; those that fewer than two patches see are none. Of
// merged planes a stop can be taken out, but no leaf, which is a part of their sums: where leaves are held out the
// others are given back what was taken over of them, and merged anew.
std::vector<PlaneFeature> planes_without(const std::vector<PlaneFeature>& features, const HeldOut& is_held_out) {
  const bool is_merged_anew =
      is_held_out.goes_by_planes() &&
      std::any_of(features.begin(), features.end(), [](const PlaneFeature& feature) { return feature.merged; });
  std::vector<PlaneFeature> kept;
  kept.reserve(features.size());
  for (std::size_t k = 0; k < features.size(); ++k) {
    const PlaneFeature& whole = features[k];
    if (is_merged_anew && whole.merged) continue;
    const auto is_kept = [&](const PlaneObservation& o) { return !is_held_out(k, o); };
    if (std::count_if(whole.observations.begin(), whole.observations.end(), is_kept) < 2) continue;
    PlaneFeature& rest = kept.emplace_back();
    std::copy_if(whole.observations.begin(), whole.observations.end(), std::back_inserter(rest.observations), is_kept);
    rest.center_G = whole.center_G;
    rest.normal_G = whole.normal_G;
    rest.size_m = whole.size_m;
    rest.merged = whole.merged;
    if (!is_merged_anew) continue;
    for (PlaneObservation& o : rest.observations) o.weight /= 1.0 - whole.merged_share;
  }
  if (is_merged_anew) merge_anew(kept);
  return kept;
}

// By how much what was held out is off the plane of the rest.
struct HeldOutOffset {
  std::size_t lidar = 0;
  double square = 0.0;
  double normalised = 0.0;
  double start_square = 0.0;
};

// What the others' plane says of the observations of one plane that are held out.
class OffsetsOfHeldOut {
 public:
  OffsetsOfHeldOut(const SolvedPlanes& solved, const HeldOut& is_held_out, const RigState& state,
                   const RigState& at_guess, const Eigen::MatrixXd& C)
      : solved_(solved), is_held_out_(is_held_out), state_(state), at_guess_(at_guess), C_(C) {}

  void add(std::size_t k, std::vector<HeldOutOffset>& out) {
    const PlaneFeature& whole = solved_.features[k];
    if (whole.merged) return;
    rest_.observations.clear();
    for (const PlaneObservation& o : whole.observations) {
      if (!is_held_out_(k, o)) rest_.observations.push_back(o);
    }
    // A plane of one patch is too short a lever to predict another's place.
    if (rest_.observations.size() < 2 || rest_.observations.size() == whole.observations.size()) return;
    plane_derivatives(rest_, state_, HessianForm::gauss_newton, plane_);
    for (const PlaneObservation& o : whole.observations) {
      if (!is_held_out_(k, o)) continue;
      const Vector3d p = state_.T_G_sensor(o.stop, o.lidar) * o.mean;
      const double e = plane_.normal.dot(p - plane_.centroid);
      // The plane's own uncertainty where it is met: its offset and its tilt times the distance from its middle.
      const double m1 = (p - plane_.centroid - e * plane_.normal).squaredNorm();
      // By all that was seen of it, also what counts in a merged plane.
      const double N = plane_.N / (1.0 - whole.merged_share);
      const double plane = 1.0 / N + m1 / (N * std::max(plane_.eigenvalues[1], 1e-6));
      const double by_poses = pose_variance(solved_, C_, state_, o, plane_.normal);
      const Vector3d p0 = at_guess_.T_G_sensor(o.stop, o.lidar) * o.mean;
      out.push_back({static_cast<std::size_t>(o.lidar), e * e, e * e / (o.offset_variance + plane + by_poses),
                     std::pow(plane_.normal.dot(p0 - plane_.centroid), 2)});
    }
  }

 private:
  const SolvedPlanes& solved_;
  const HeldOut& is_held_out_;
  const RigState& state_;
  const RigState& at_guess_;
  const Eigen::MatrixXd& C_;
  PlaneFeature rest_;
  PlaneDerivatives plane_;
};

bool lies_on_planes(const SolvedPlanes& solved, int lidar) {
  return std::any_of(solved.features.begin(), solved.features.end(), [&](const PlaneFeature& feature) {
    return std::any_of(feature.observations.begin(), feature.observations.end(),
                       [&](const PlaneObservation& o) { return o.lidar == lidar; });
  });
}

// By who is held out, and how many offsets of each LiDAR that gave.
HoldOut hold_out_by(const HeldOut& is_held_out, const SolvedPlanes& solved, const std::vector<SE3>& guess,
                    std::vector<double>& count) {
  const auto lidars = static_cast<std::size_t>(solved.layout.lidars());
  HoldOut out;
  out.normalised.assign(lidars, 0.0);
  out.rms_m.assign(lidars, 0.0);
  out.start_rms_m.assign(lidars, 0.0);
  count.assign(lidars, 0.0);
  const std::vector<PlaneFeature> kept = planes_without(solved.features, is_held_out);
  RigState state = solved.state;
  const AdjustSummary adjusted = adjust(kept, solved.layout, solved.adjust, state);
  // Where nothing could be moved the held-out stops still stand in the extrinsics, and check nothing.
  const bool is_stuck = !adjusted.converged && adjusted.cost_after >= adjusted.cost_before;
  out.T_base_sensor = state.T_base_sensor;
  if (is_stuck && solved.layout.size() > 0) return out;
  RigState at_guess = state;
  for (std::size_t i = 0; i < std::min(lidars, guess.size()); ++i) at_guess.T_base_sensor[i] = guess[i];

  const Eigen::MatrixXd C = covariance_by(kept, solved, state);
  constexpr std::size_t grain = 128;
  std::vector<std::vector<HeldOutOffset>> offsets((solved.features.size() + grain - 1) / grain);
  parallel_for(solved.features.size(), grain, [&](std::size_t begin, std::size_t end) {
    OffsetsOfHeldOut held_out(solved, is_held_out, state, at_guess, C);
    for (std::size_t k = begin; k < end; ++k) held_out.add(k, offsets[begin / grain]);
  });
  for (const std::vector<HeldOutOffset>& part : offsets) {
    for (const HeldOutOffset& offset : part) {
      out.rms_m[offset.lidar] += offset.square;
      out.normalised[offset.lidar] += offset.normalised;
      out.start_rms_m[offset.lidar] += offset.start_square;
      count[offset.lidar] += 1.0;
    }
  }
  for (std::size_t i = 0; i < lidars; ++i) {
    for (std::vector<double>* of_all : {&out.normalised, &out.rms_m, &out.start_rms_m}) {
      (*of_all)[i] = count[i] < least_offsets ? 0.0 : std::sqrt((*of_all)[i] / count[i]);
    }
  }
  return out;
}

}  // namespace

HoldOut hold_out(const SolvedPlanes& solved, int base, const std::vector<SE3>& guess) {
  HeldOut is_held_out(solved, base);
  std::vector<double> count;
  HoldOut out = hold_out_by(is_held_out, solved, guess, count);
  if (!is_held_out.goes_by_stops()) return out;
  bool is_unchecked = false;
  for (int i = 0; i < solved.layout.lidars(); ++i) {
    if (i == base || count[static_cast<std::size_t>(i)] >= least_offsets || !lies_on_planes(solved, i)) continue;
    is_held_out.go_by_own_stops(solved, i);
    is_unchecked = true;
  }
  return is_unchecked ? hold_out_by(is_held_out, solved, guess, count) : out;
}

}  // namespace rigcal
