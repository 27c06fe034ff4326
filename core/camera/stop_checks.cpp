#include "core/camera/stop_checks.h"

#include <algorithm>

#include "core/camera/camera_checks.h"
#include "core/geometry/matrix6.h"

namespace rigcal {
namespace {

// With fewer stops a half may end elsewhere though the whole is right.
constexpr std::size_t least_stops_of_half = 6;

// From the end it is not far, and half of the stops need not be as exact as all.
constexpr int iterations_again = 12;

struct Parts {
  std::vector<EdgeView> some;
  std::vector<EdgeView> others;
};

// Views of every `modulus`th stop, from the one after `remainder` others, and the rest. Stops without a view do not
// count: images of odd stops alone have halves, too.
Parts divide(const std::vector<EdgeView>& views, std::ptrdiff_t modulus, std::ptrdiff_t remainder) {
  std::vector<int> stops;
  for (const EdgeView& view : views) stops.push_back(view.stop);
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  Parts parts;
  for (const EdgeView& view : views) {
    const std::ptrdiff_t place = std::lower_bound(stops.begin(), stops.end(), view.stop) - stops.begin();
    (place % modulus == remainder ? parts.some : parts.others).push_back(view);
  }
  return parts;
}

CameraState solve_again(const SolvedCamera& solved, const EdgeSolution& end, const std::vector<EdgeView>& views,
                        const RunContext& context) {
  SolveLevel level = solved.level;
  level.max_iterations = iterations_again;
  return solve_edges(solved.scene, solved.camera.intrinsics, end.state, solved.priors, std::span(&level, 1), views,
                     context)
      .state;
}

void hold_out(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
              CameraEstimate& estimate) {
  const Parts parts = divide(solved.views, 4, 3);
  if (parts.some.empty() || parts.others.empty()) return;
  const CameraIntrinsics& intrinsics = solved.camera.intrinsics;
  const CameraState state = solve_again(solved, end, parts.others, context);
  const EdgeFitQuality unseen = fit_quality(solved.scene, intrinsics, state, solved.level.match, parts.some);
  estimate.hold_out = unseen.normalised;
  estimate.hold_out_px = unseen.residual_px;
  const std::optional<SE3>& guess = solved.camera.guess_T_base_camera;
  if (!guess) return;
  estimate.hold_out_start_px =
      offset_from(solved.scene, intrinsics, end.state, CameraState{*guess}, solved.level.match, parts.some);
}

void compare_halves(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
                    CameraEstimate& estimate) {
  const Parts halves = divide(solved.views, 2, 0);
  if (halves.some.empty() || halves.others.empty()) return;
  const SE3 T_base_even = solve_again(solved, end, halves.some, context).T_base_camera;
  const SE3 T_base_odd = solve_again(solved, end, halves.others, context).T_base_camera;
  const Vector6d apart = (T_base_even.inverse() * T_base_odd).log();
  estimate.halves_rad = apart.head<3>().norm();
  estimate.halves_m = apart.tail<3>().norm();
  if (std::min(stops_of(halves.some), stops_of(halves.others)) < least_stops_of_half) return;
  // Each half has twice the variance of the whole, and their difference four times.
  estimate.halves_chi2 = 0.25 * apart.dot(solve_symmetric6(estimate.pose.covariance, apart));
}

}  // namespace

void check_by_stops(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
                    CameraEstimate& estimate) {
  hold_out(solved, end, context, estimate);
  compare_halves(solved, end, context, estimate);
}

}  // namespace rigcal
