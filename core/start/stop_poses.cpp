#include "core/start/stop_poses.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/median.h"
#include "core/start/axis_search.h"
#include "core/start/drive.h"
#include "core/start/multiview.h"
#include "core/start/overlap_limits.h"
#include "core/start/own_view.h"
#include "core/start/signed_turns.h"
#include "core/start/step_search.h"
#include "core/start/step_tree.h"
#include "core/start/turning.h"

namespace rigcal {
namespace {

// Where less of what the base saw lies on what it saw from other stops, it may not have turned about a point.
constexpr double turning_agreement = 0.85;
// By how much more must, to believe so.
constexpr double clear_gain = 0.02;
// Steps of a table that turns equally by hand; of one whose turns were measured.
constexpr double assumed_step_sigma_rad = to_rad(3.0);
constexpr double measured_step_sigma_rad = to_rad(0.5);

bool gyro_is_complete(const StartInput& input) {
  if (static_cast<int>(input.R_previous_this.size()) != input.stops) return false;
  return std::all_of(input.R_previous_this.begin() + 1, input.R_previous_this.end(),
                     [](const auto& R) { return R.has_value(); });
}

struct Turned {
  std::vector<double> angle;  // by stop
  double step_sigma_rad = measured_step_sigma_rad;
  bool is_assumed = false;  // some step was told by nothing
};

// Where nothing is known, a full turn in equal steps.
Turned turned_angles(const StartInput& input) {
  const auto stops = static_cast<std::size_t>(input.stops);
  Turned out{std::vector<double>(stops, 0.0)};
  const std::vector<std::optional<double>> by_gyro = signed_turns(input.R_previous_this);
  for (std::size_t j = 1; j < stops; ++j) {
    std::optional<double> step;
    if (j < input.turned_rad.size()) step = input.turned_rad[j];
    if (j < by_gyro.size() && by_gyro[j]) step = by_gyro[j];
    if (!step) {
      out.step_sigma_rad = assumed_step_sigma_rad;
      out.is_assumed = true;
    }
    out.angle[j] = out.angle[j - 1] + step.value_or(2.0 * pi / input.stops);
  }
  return out;
}

std::vector<Matrix3d> rotations_by_gyro(const StartInput& input) {
  std::vector<Matrix3d> R{Matrix3d::Identity()};
  for (std::size_t j = 1; j < static_cast<std::size_t>(input.stops); ++j)
    R.push_back(nearest_rotation(R.back() * *input.R_previous_this[j]));
  return R;
}

}  // namespace

void place_stops(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  const auto stops = static_cast<std::size_t>(input.stops);
  start.state.T_G_base.assign(stops, SE3{});
  start.stop_known.assign(stops, 0);
  for (const PatchSurfels& p : base_patches) start.stop_known[static_cast<std::size_t>(p.stop)] = 1;
  if (!input.trajectory.empty()) {
    // The world is the rig frame at the first stop.
    SE3 T_first;
    for (const auto& T : input.trajectory) {
      if (T) {
        T_first = *T;
        break;
      }
    }
    start.stop_known.assign(stops, 0);
    for (std::size_t j = 0; j < stops; ++j) {
      if (!input.trajectory[j]) continue;
      start.state.T_G_base[j] = T_first.inverse() * *input.trajectory[j];
      start.stop_known[j] = 1;
    }
    start.given_T_G_base = start.state.T_G_base;
  } else if (stops > 1 && gyro_is_complete(input)) {
    start.state.T_G_base = poses_from_rotations(base_patches, rotations_by_gyro(input));
  } else if (stops > 1 && !input.axis) {
    const Turned turned = turned_angles(input);
    AxisSearchOptions options;
    options.step_sigma_rad = turned.step_sigma_rad;
    const std::vector<OwnTurn> own = find_own_turns(base_patches, turned.angle, options);
    if (!own.empty() && own.front().score >= min_own_score) {
      start.state.T_G_base = own.front().T_zero_this;
    } else {
      // Nothing holds the stops together; the first that is known stays alone.
      const auto first = std::find(start.stop_known.begin(), start.stop_known.end(), 1);
      if (first != start.stop_known.end()) std::fill(first + 1, start.stop_known.end(), 0);
    }
  } else if (stops > 1) {
    std::vector<double> scores;
    // The search is sure of the rotations only: a poor view slides by metres. That the rig turned about a point holds
    // it.
    const std::vector<Matrix3d> R =
        rotations_from_search(base_patches, input.stops, *input.axis, input.R_previous_this, scores);
    start.state.T_G_base = poses_from_rotations(base_patches, R);
    for (std::size_t j = 0; j < stops; ++j) {
      if (scores[j] < min_score) start.stop_known[j] = 0;
    }
  }
}

std::vector<PatchSurfels> known_of(std::vector<PatchSurfels> patches, const Start& start) {
  std::erase_if(patches, [&](const PatchSurfels& p) { return !start.stop_known[static_cast<std::size_t>(p.stop)]; });
  return patches;
}

bool has_unknown_steps(const StartInput& input) {
  return input.trajectory.empty() && input.axis && input.stops > 2 && !gyro_is_complete(input);
}

bool turns_in_assumed_steps(const StartInput& input) {
  return input.trajectory.empty() && input.stops > 1 && turned_angles(input).is_assumed;
}

void place_by_evidence(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  const FoundTurns turns = rotations_by_evidence(base_patches, input.stops, *input.axis, input.R_previous_this);
  start.stop_known = turns.found;
  // How the others are turned says nothing about the foot.
  start.state.T_G_base = poses_from_rotations(known_of(base_patches, start), turns.R_G_base);
}

void place_in_equal_steps(const StartInput& input, const std::vector<PatchSurfels>& base_patches, double way,
                          Start& start) {
  std::vector<Matrix3d> R;
  for (const double angle : turned_angles(input).angle) R.push_back(exp_so3(way * angle * *input.axis));
  start.state.T_G_base = poses_from_rotations(base_patches, R);
  start.stop_known.assign(static_cast<std::size_t>(input.stops), 0);
  for (const PatchSurfels& p : base_patches) start.stop_known[static_cast<std::size_t>(p.stop)] = 1;
}

StopStep usual_step(const std::vector<SE3>& T_G_base, const std::vector<char>& known) {
  std::vector<double> turns;
  std::vector<double> moves;
  const SE3* before = nullptr;
  for (std::size_t j = 0; j < T_G_base.size(); ++j) {
    if (!known[j]) continue;
    if (before != nullptr) {
      turns.push_back(rotation_distance(before->R, T_G_base[j].R));
      moves.push_back((T_G_base[j].t - before->t).norm());
    }
    before = &T_G_base[j];
  }
  if (turns.empty()) return {};
  return {median(std::move(turns)), median(std::move(moves))};
}

void refine_stops(const StartInput& input, const std::vector<PatchSurfels>& patches, const StopHold& hold,
                  Start& start) {
  ParameterLayout layout(input.stops, input.lidars);
  MultiviewOptions options;
  options.priors.stop_priors.resize(static_cast<std::size_t>(input.stops));
  for (const PatchSurfels& p : patches) {
    if (p.stop == patches.front().stop) continue;
    layout.free_stop(p.stop);
    const auto j = static_cast<std::size_t>(p.stop);
    options.priors.stop_priors[j] = isotropic_prior(start.state.T_G_base[j], hold.rotation_rad, hold.translation_m);
  }
  align_surfels(patches, layout, options, start.state);
}

void try_other_ways(const StartInput& input, const std::vector<PatchSurfels>& base_patches, Start& start) {
  if (!input.trajectory.empty() || input.stops < 2 || !gyro_is_complete(input)) return;
  double best = balanced_agreement(base_patches, start.state.T_G_base);
  const auto try_poses = [&](const std::vector<SE3>& T_G_base) {
    Start other = start;
    other.state.T_G_base = T_G_base;
    refine_stops(input, base_patches, loose_hold, other);
    const double score = balanced_agreement(base_patches, other.state.T_G_base);
    if (score <= best + clear_gain) return;
    best = score;
    start.state.T_G_base = other.state.T_G_base;
  };
  // An axis that the base's own gyro told is not to be searched for: what sees little from two stops fits any.
  if (best < turning_agreement && !input.turns_are_own) {
    AxisSearchOptions options;
    options.step_sigma_rad = measured_step_sigma_rad;
    const std::vector<OwnTurn> own = find_own_turns(base_patches, turned_angles(input).angle, options);
    if (!own.empty()) try_poses(own.front().T_zero_this);
  }
  if (best < turning_agreement) try_poses(poses_of_drive(base_patches, rotations_by_gyro(input)));
}

}  // namespace rigcal
