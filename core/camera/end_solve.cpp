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
constexpr double free_principal = 0.02;  // of the focal length

// A start is near: matches need not be sought as far away as at first.
constexpr std::size_t fine_levels = 3;

}  // namespace

EdgePriors with_free_intrinsics(EdgePriors priors) {
  priors.focal_scale = std::max(priors.focal_scale, free_focal_scale);
  priors.k1 = std::max(priors.k1, free_k1);
  return priors;
}

bool is_off(const ScalarEstimate& change) { return std::abs(change.value) > 3.0 * change.sigma; }

bool is_off_px(const ScalarEstimate& change, double chance_px) {
  return std::abs(change.value) > 3.0 * std::hypot(change.sigma, chance_px);
}

namespace {

struct Lens {
  ScalarEstimate focal_scale;
  ScalarEstimate k1_change;
  ScalarEstimate radial_trend;
  ScalarEstimate cx_change_px;
  ScalarEstimate cy_change_px;

  [[nodiscard]] bool has_other_centre() const { return is_off_px(cx_change_px) || is_off_px(cy_change_px); }
};

Lens lens_of(const CameraIntrinsics& intrinsics, const EdgeSolution& solution) {
  const CameraState& state = solution.state;
  const CameraMatrix covariance = solution.information.inverse();
  const auto sigma = [&](int k) { return std::sqrt(covariance(k, k)); };
  return {{state.focal_scale, sigma(6)},
          {state.k1_change, sigma(7)},
          corner_shift(intrinsics, state, covariance.block<2, 2>(pose_parameters, pose_parameters)),
          {state.principal_change_px.x(), sigma(8)},
          {state.principal_change_px.y(), sigma(9)}};
}

}  // namespace

CameraEnd solve_end(const CameraScene& scene, const CameraTask& camera, bool refine_intrinsics,
                    const EdgePriors& priors, const CameraState& start, std::vector<EdgeView>& views,
                    const RunContext& context) {
  VisibleOptions visible;
  visible.stride = fine_stride;
  find_visible(scene, camera.intrinsics, start, visible, views);
  const std::vector<SolveLevel> all = standard_levels();
  const std::span<const SolveLevel> levels = std::span(all).last(fine_levels);
  CameraEnd end;
  const auto solve = [&](const EdgePriors& under) {
    end.priors = under;
    end.solution = solve_edges(scene, camera.intrinsics, start, under, levels, views, context);
    end.iterations += end.solution.iterations;
    // A few images can be explained by many intrinsics, and those that never came to rest say nothing: only who asks
    // for them gets to see what they would be.
    const bool is_known = end.solution.converged && stops_of(views) >= least_stops_for_intrinsics;
    return is_known || refine_intrinsics ? lens_of(camera.intrinsics, end.solution) : Lens{};
  };
  const auto tell = [&](const Lens& lens) {
    end.focal_scale = lens.focal_scale;
    end.k1_change = lens.k1_change;
    end.radial_trend = lens.radial_trend;
  };
  // With a principal point that is free, too, turns are known less well: only where it must be.
  EdgePriors all_free = with_free_intrinsics(priors);
  all_free.principal_px = free_principal * camera.intrinsics.fx;
  const Lens free = solve(all_free);
  end.cx_change_px = free.cx_change_px;
  end.cy_change_px = free.cy_change_px;
  tell(free);
  if (free.has_other_centre()) return end;
  const Lens lens = solve(with_free_intrinsics(priors));
  tell(lens);
  if (refine_intrinsics || is_off(lens.focal_scale) || is_off(lens.k1_change)) return end;
  (void)solve(priors);
  return end;
}

}  // namespace rigcal
