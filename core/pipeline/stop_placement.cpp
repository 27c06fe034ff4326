#include "core/pipeline/stop_placement.h"

#include <algorithm>
#include <cmath>

#include "core/quality/turning_axis.h"
#include "core/start/registration.h"

namespace rigcal {
namespace {

// As much of the map, and of what is laid on it, as decides upon centimetres.
constexpr std::size_t most_in_map = 24000;
constexpr std::size_t most_moving = 3000;
constexpr double reach_m = 0.5;
constexpr double min_score = 0.3;

bool is_known(const Start& solved, const PatchSurfels& patch) {
  return solved.lidar_known[static_cast<std::size_t>(patch.lidar)] != 0;
}

SurfelIndex map_before(const PlacementInput& input) {
  const auto is_used = [&](const PatchSurfels& patch) {
    return patch.stop < input.stop && is_known(input.solved, patch) &&
           input.solved.stop_known[static_cast<std::size_t>(patch.stop)];
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
  return {without_repetitions(map, 0.25), reach_m};
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

}  // namespace

std::optional<SE3> place_stop(const PlacementInput& input) {
  const MovingSurfels moving = seen_at(input);
  if (moving.items.empty()) return std::nullopt;
  const std::vector<SE3>& poses = input.solved.state.T_G_base;
  SE3 T{nearest_rotation(poses.back().R * input.R_previous_this), poses.back().t};
  if (const auto axis = find_turning_axis(poses, input.solved.stop_known, Vector3d::UnitZ())) {
    T.t = axis->point - T.R * axis->point;
  }
  const SurfelIndex map = map_before(input);
  T = refine_registration(map, moving, T, 0.3, 0.06);
  if (match_score(map, moving, T, same_surface_cosine, same_surface_m) < min_score) return std::nullopt;
  return T;
}

}  // namespace rigcal
