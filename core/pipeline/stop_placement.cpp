#include "core/pipeline/stop_placement.h"

#include <algorithm>
#include <cmath>

#include "core/geometry/angles.h"
#include "core/quality/turning_axis.h"
#include "core/start/registration.h"
#include "core/start/step_search.h"

namespace rigcal {
namespace {

// As much of the map, and of what is laid on it, as decides upon centimetres.
constexpr std::size_t most_in_map = 24000;
constexpr std::size_t most_moving = 3000;
constexpr double reach_m = 0.5;
constexpr double coarse_reach_m = 1.0;
constexpr double min_score = 0.3;

// Of a circle that is searched.
constexpr int step_deg = 3;
// What is laid down without any word of its turn: a floor alone, which fits every turn, is a third.
constexpr double min_found_score = 0.5;
// Found about the line of the turns so far it stands no farther off it.
constexpr double off_axis_rad = to_rad(3.0);
constexpr double off_axis_m = 0.3;
// A step like the others is left only for one that fits this much better, and that no other comes near to.
constexpr double clearly_better = 1.3;
constexpr double sure_ratio = 0.75;

bool is_known(const Start& solved, const PatchSurfels& patch) {
  return solved.lidar_known[static_cast<std::size_t>(patch.lidar)] != 0;
}

// What was seen from the other stops.
std::vector<PlacedSurfel> map_of(const PlacementInput& input) {
  const auto is_used = [&](const PatchSurfels& patch) {
    const auto j = static_cast<std::size_t>(patch.stop);
    return patch.stop != input.stop && is_known(input.solved, patch) && j < input.solved.stop_known.size() &&
           input.solved.stop_known[j];
  };
  std::size_t count = 0;
  for (const PatchSurfels& patch : input.surfels) count += is_used(patch) ? patch.surfels.size() : 0;
  const std::size_t step = count / most_in_map + 1;
  std::vector<PlacedSurfel> map;
  std::size_t at = 0;
  for (const PatchSurfels& patch : input.surfels) {
    if (!is_used(patch)) continue;
    const SE3 T = input.solved.state.T_G_sensor(patch.stop, patch.lidar);
    for (const Surfel& s : patch.surfels) {
      if (at++ % step == 0) map.push_back({T * s.mean, T.R * s.normal, patch.stop});
    }
  }
  return map;
}

MovingSurfels seen_at(const PlacementInput& input) {
  MovingSurfels moving{{SE3{}}, {}};
  for (const PatchSurfels& patch : input.surfels) {
    if (patch.stop != input.stop || !is_known(input.solved, patch)) continue;
    const SE3& E = input.solved.state.T_base_sensor[static_cast<std::size_t>(patch.lidar)];
    for (const Surfel& s : patch.surfels) moving.items.push_back({0, E * s.mean, E.R * s.normal});
  }
  return thinned(moving, most_moving);
}

std::optional<TurningAxis> axis_so_far(const PlacementInput& input) {
  return find_turning_axis(input.solved.state.T_G_base, input.solved.stop_known, Vector3d::UnitZ());
}

double angle_between(const SE3& T_G_a, const SE3& T_G_b, const TurningAxis& axis) {
  return log_so3(T_G_b.R * T_G_a.R.transpose()).dot(axis.direction);
}

// The one that more than half of the steps between neighbours are like; of two nobody could say so.
std::optional<double> usual_step(const Start& solved, const TurningAxis& axis) {
  std::vector<double> steps;
  for (std::size_t j = 1; j < solved.stop_known.size(); ++j) {
    if (!solved.stop_known[j - 1] || !solved.stop_known[j]) continue;
    steps.push_back(angle_between(solved.state.T_G_base[j - 1], solved.state.T_G_base[j], axis));
  }
  std::size_t most = 1;
  std::optional<double> usual;
  for (const double step : steps) {
    const auto is_alike = [&](double other) { return angle_apart(step, other) < alike_step_rad; };
    const auto alike = static_cast<std::size_t>(std::count_if(steps.begin(), steps.end(), is_alike));
    if (alike <= most || 2 * alike <= steps.size()) continue;
    most = alike;
    usual = step;
  }
  return usual;
}

bool is_turn_about(const TurningAxis& axis, const SE3& T_G_from, const SE3& T_G_this) {
  const SE3 off = (axis.turn(angle_between(T_G_from, T_G_this, axis)) * T_G_from).inverse() * T_G_this;
  return log_so3(off.R).norm() < off_axis_rad && off.t.norm() < off_axis_m;
}

}  // namespace

bool saw_anything(const PlacementInput& input) {
  return std::any_of(input.surfels.begin(), input.surfels.end(), [&](const PatchSurfels& patch) {
    return patch.stop == input.stop && is_known(input.solved, patch) && !patch.surfels.empty();
  });
}

std::optional<SE3> place_stop(const PlacementInput& input, const Matrix3d& R_from_this) {
  const MovingSurfels moving = seen_at(input);
  if (moving.items.empty()) return std::nullopt;
  const SE3& T_G_from = input.solved.state.T_G_base[static_cast<std::size_t>(input.from)];
  SE3 T{nearest_rotation(T_G_from.R * R_from_this), T_G_from.t};
  if (const auto axis = axis_so_far(input)) T.t = axis->point - T.R * axis->point;
  const SurfelIndex map(without_repetitions(map_of(input), 0.25), reach_m);
  T = refine_registration(map, moving, T, 0.3, 0.06);
  if (match_score(map, moving, T, same_surface_cosine, same_surface_m) < min_score) return std::nullopt;
  return T;
}

std::optional<SE3> find_stop(const PlacementInput& input) {
  const MovingSurfels moving = seen_at(input);
  const std::optional<TurningAxis> axis = axis_so_far(input);
  if (moving.items.empty() || !axis) return std::nullopt;
  const SE3& T_G_from = input.solved.state.T_G_base[static_cast<std::size_t>(input.from)];
  const std::optional<double> usual = usual_step(input.solved, *axis);
  const double expected = usual.value_or(0.0) * (input.stop - input.from);
  const auto is_usual = [&](double angle) { return usual && angle_apart(angle, expected) <= alike_step_rad; };
  std::vector<SE3> all_round;
  std::vector<SE3> as_usual;
  for (int deg = 0; deg < 360; deg += step_deg) {
    all_round.push_back(axis->turn(to_rad(deg)) * T_G_from);
    if (is_usual(to_rad(deg))) as_usual.push_back(all_round.back());
  }
  const std::vector<PlacedSurfel> map = map_of(input);
  const SurfelIndex coarse(without_repetitions(map, 1.0), coarse_reach_m);
  const SurfelIndex fine(without_repetitions(map, 0.25), reach_m);
  const auto found_from = [&](const std::vector<SE3>& starts) {
    std::vector<ScoredPose> found = refined_poses(coarse, fine, moving, starts);
    std::erase_if(found, [&](const ScoredPose& pose) {
      return pose.score < min_found_score || !is_turn_about(*axis, T_G_from, pose.X);
    });
    return found;
  };
  const std::vector<ScoredPose> far = found_from(all_round);
  std::vector<ScoredPose> near = found_from(as_usual);
  std::erase_if(near, [&](const ScoredPose& pose) { return !is_usual(angle_between(T_G_from, pose.X, *axis)); });
  if (!near.empty() && (far.empty() || far.front().score < clearly_better * near.front().score)) return near.front().X;
  if (far.empty() || (far.size() > 1 && far[1].score >= sure_ratio * far[0].score)) return std::nullopt;
  return far.front().X;
}

void find_left_out(const std::vector<PatchSurfels>& surfels, Start& start) {
  const auto stops = static_cast<int>(start.stop_known.size());
  const auto is_known = [&](int j) {
    return j >= 0 && j < stops && start.stop_known[static_cast<std::size_t>(j)] != 0;
  };
  // What is found is a known neighbour of the next one.
  for (bool found = true; found;) {
    found = false;
    for (int j = 0; j < stops; ++j) {
      if (is_known(j) || !(is_known(j - 1) || is_known(j + 1))) continue;
      const std::optional<SE3> T = find_stop({start, surfels, j, is_known(j - 1) ? j - 1 : j + 1});
      if (!T) continue;
      start.state.T_G_base[static_cast<std::size_t>(j)] = *T;
      start.stop_known[static_cast<std::size_t>(j)] = 1;
      found = true;
    }
  }
}

}  // namespace rigcal
