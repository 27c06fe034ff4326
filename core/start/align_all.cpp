#include "core/start/align_all.h"

#include <algorithm>
#include <cmath>

#include "core/start/multiview.h"

namespace rigcal {
namespace {

// Surfels are laid on each other until nothing moves by more than this.
constexpr double settled_m = 0.03;
// What is looked for around each, in the next of these times.
constexpr double least_from_m = 0.12;
constexpr double most_from_m = 0.3;

void set_alignment_priors(const StartInput& input, const Start& start, const StopHold& hold, AdjustOptions& priors) {
  priors.lidar_priors.assign(static_cast<std::size_t>(input.lidars), {});
  priors.stop_priors.assign(static_cast<std::size_t>(input.stops), {});
  for (int j = 0; j < input.stops; ++j) {
    const auto sj = static_cast<std::size_t>(j);
    priors.stop_priors[sj] = isotropic_prior(start.state.T_G_base[sj], hold.rotation_rad, hold.translation_m);
  }
  for (int i = 0; i < input.lidars; ++i) {
    const auto si = static_cast<std::size_t>(i);
    if (i == input.base || !start.lidar_known[si]) continue;
    priors.lidar_priors[si] = isotropic_prior(start.state.T_base_sensor[si], to_rad(3.0), 0.3);
    if (start.shape_matches[si]) priors.lidar_priors[si] = prior_of(*start.shape_matches[si]);
  }
}

// Of any pose, a turn at three metres.
double largest_move(const RigState& before, const RigState& after) {
  constexpr double arm_m = 3.0;
  double most = 0.0;
  const auto measure = [&](const std::vector<SE3>& a, const std::vector<SE3>& b) {
    for (std::size_t k = 0; k < a.size(); ++k)
      most = std::max(most, (a[k].t - b[k].t).norm() + arm_m * rotation_distance(a[k].R, b[k].R));
  };
  measure(before.T_G_base, after.T_G_base);
  measure(before.T_base_sensor, after.T_base_sensor);
  return most;
}

}  // namespace

void align_all(const StartInput& input, const std::vector<PatchSurfels>& patches, double from_m, const StopHold& hold,
               int most, Start& start) {
  ParameterLayout layout(input.stops, input.lidars);
  std::vector<PatchSurfels> used;
  int first = -1;
  for (const PatchSurfels& p : patches) {
    if (start.lidar_known[static_cast<std::size_t>(p.lidar)] && start.stop_known[static_cast<std::size_t>(p.stop)])
      used.push_back(p);
  }
  for (int j = 0; j < input.stops; ++j) {
    const bool seen = std::any_of(used.begin(), used.end(), [&](const PatchSurfels& p) { return p.stop == j; });
    if (!seen) continue;
    if (first < 0)
      first = j;
    else
      layout.free_stop(j);
  }
  for (int i = 0; i < input.lidars; ++i) {
    if (i != input.base && start.lidar_known[static_cast<std::size_t>(i)]) layout.free_lidar(i);
  }
  MultiviewOptions options;
  options.from_m = from_m;
  options.to_m = 0.05;
  if (!input.trajectory.empty()) most = 1;
  for (int k = 0; k < most; ++k) {
    const RigState before = start.state;
    set_alignment_priors(input, start, hold, options.priors);
    align_surfels(used, layout, options, start.state);
    const double moved_m = largest_move(before, start.state);
    if (moved_m < settled_m) break;
    options.from_m = std::clamp(moved_m, least_from_m, most_from_m);
  }
}

}  // namespace rigcal
