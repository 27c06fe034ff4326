#include "core/camera/stop_checks.h"

#include <Eigen/LU>
#include <algorithm>

#include "core/camera/camera_checks.h"
#include "core/camera/stop_agreement.h"
#include "core/geometry/matrix6.h"

namespace rigcal {
namespace {

// With fewer stops a half may end elsewhere though the whole is right.
constexpr std::size_t least_stops_of_half = 6;

// Fewer stops may end anywhere, with a good conscience.
constexpr std::size_t least_stops_of_third = 3;

// From the end it is not far, and half of the stops need not be as exact as all.
constexpr int iterations_again = 12;

struct Parts {
  std::vector<EdgeView> some;
  std::vector<EdgeView> others;
};

// Those of a view. Stops without one do not count: images of odd stops alone have halves, too.
std::vector<int> stops_in_order(const std::vector<EdgeView>& views) {
  std::vector<int> stops;
  for (const EdgeView& view : views) stops.push_back(view.stop);
  std::sort(stops.begin(), stops.end());
  stops.erase(std::unique(stops.begin(), stops.end()), stops.end());
  return stops;
}

// Views of every `modulus`th stop, from the one after `remainder` others, and the rest.
Parts divide(const std::vector<EdgeView>& views, std::ptrdiff_t modulus, std::ptrdiff_t remainder) {
  const std::vector<int> stops = stops_in_order(views);
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
  estimate.stops = agreement_of_stops(solved.scene, intrinsics, state, solved.level.match, solved.views);
  double shown = 0.0;
  double expected = 0.0;
  for (const StopAgreement& stop : estimate.stops) {
    const auto is_of_it = [&](const EdgeView& view) { return view.stop == stop.stop; };
    if (std::none_of(parts.some.begin(), parts.some.end(), is_of_it)) continue;
    shown += stop.more_than_chance();
    expected += stop.expected;
  }
  if (expected > 0.0) estimate.hold_out_share = shown / expected;
  for (StopAgreement& stop : estimate.stops) {
    const auto is_of_it = [&](const CameraView& view) { return view.stop == stop.stop; };
    stop.file = std::find_if(solved.camera.views.begin(), solved.camera.views.end(), is_of_it)->file;
  }
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

// What some of the stops tell by themselves.
struct Witness {
  EdgeSolution own;
  double gain = 0.0;  // What they explain at their own pose, over that at the end of all.
};

// A camera that was turned a little stands farther from the end than its partners are sought: from afar again.
Witness ask(const SolvedCamera& solved, const EdgeSolution& end, const std::vector<EdgeView>& views,
            const RunContext& context) {
  const CameraIntrinsics& intrinsics = solved.camera.intrinsics;
  std::vector<SolveLevel> levels = quick_levels();
  for (SolveLevel& level : levels) level.intrinsics = solved.level.intrinsics;
  levels.back().max_iterations = iterations_again;
  Witness witness{solve_edges(solved.scene, intrinsics, end.state, solved.priors, levels, views, context)};
  const auto explained = [&](const CameraState& state) {
    return sum_segments(solved.scene, intrinsics, state, solved.level.match, views).explained;
  };
  const double by_all = explained(end.state);
  if (by_all > 0.0) witness.gain = explained(witness.own.state) / by_all;
  return witness;
}

void compare_first_and_last(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
                            CameraEstimate& estimate) {
  const std::vector<int> stops = stops_in_order(solved.views);
  const std::size_t count = std::max(least_stops_of_third, stops.size() / 3);
  if (stops.size() < 2 * count) return;
  Parts parts;
  for (const EdgeView& view : solved.views) {
    if (view.stop <= stops[count - 1]) parts.some.push_back(view);
    if (view.stop >= stops[stops.size() - count]) parts.others.push_back(view);
  }
  const Witness first = ask(solved, end, parts.some, context);
  const Witness last = ask(solved, end, parts.others, context);
  const Vector6d apart = (first.own.state.T_base_camera.inverse() * last.own.state.T_base_camera).log();
  const CameraMatrix covariance = first.own.information.inverse() + last.own.information.inverse();
  estimate.first_and_last = {apart.tail<3>().norm(), apart.head<3>().norm(),
                             apart.dot(solve_symmetric6(covariance.topLeftCorner<6, 6>(), apart)),
                             std::max(first.gain, last.gain)};
}

}  // namespace

void check_by_stops(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
                    CameraEstimate& estimate) {
  hold_out(solved, end, context, estimate);
  compare_halves(solved, end, context, estimate);
  compare_first_and_last(solved, end, context, estimate);
}

}  // namespace rigcal
