#include "core/camera/end_solve.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <span>

#include "core/camera/camera_checks.h"

namespace rigcal {
namespace {

// In the end each edge counts, but half of the samples hide as much as all.
constexpr std::size_t fine_stride = 2;

// Sigmas of intrinsics that are to be found: no calibration is off by more.
constexpr double free_focal_scale = 0.02;
constexpr double free_k1 = 0.1;

// A start is near: matches need not be sought as far away as at first.
constexpr std::size_t fine_levels = 3;

}  // namespace

EdgePriors with_free_intrinsics(EdgePriors priors) {
  priors.focal_scale = std::max(priors.focal_scale, free_focal_scale);
  priors.k1 = std::max(priors.k1, free_k1);
  return priors;
}

bool is_off(const ScalarEstimate& change) { return std::abs(change.value) > 3.0 * change.sigma; }

CameraEnd solve_end(const CameraScene& scene, const CameraTask& camera, bool refine_intrinsics,
                    const EdgePriors& priors, const CameraState& start, std::vector<EdgeView>& views,
                    const RunContext& context) {
  VisibleOptions visible;
  visible.stride = fine_stride;
  find_visible(scene, camera.intrinsics, start, visible, views);
  const std::vector<SolveLevel> all = standard_levels();
  const std::span<const SolveLevel> levels = std::span(all).last(fine_levels);
  CameraEnd end;
  end.priors = with_free_intrinsics(priors);
  end.solution = solve_edges(scene, camera.intrinsics, start, end.priors, levels, views, context);
  end.iterations = end.solution.iterations;
  // A few images can be explained by many intrinsics, and those that never came to rest say nothing: only who asks
  // for them gets to see what they would be.
  const bool are_known = end.solution.converged && stops_of(views) >= least_stops_for_intrinsics;
  if (are_known || refine_intrinsics) {
    const CameraState& state = end.solution.state;
    const CameraMatrix covariance = end.solution.information.inverse();
    end.focal_scale = {state.focal_scale, std::sqrt(covariance(6, 6))};
    end.k1_change = {state.k1_change, std::sqrt(covariance(7, 7))};
    end.radial_trend = corner_shift(camera.intrinsics, state, covariance.bottomRightCorner<2, 2>());
  }
  if (refine_intrinsics || is_off(end.focal_scale) || is_off(end.k1_change)) return end;
  end.priors = priors;
  end.solution = solve_edges(scene, camera.intrinsics, start, priors, levels, views, context);
  end.iterations += end.solution.iterations;
  return end;
}

}  // namespace rigcal
