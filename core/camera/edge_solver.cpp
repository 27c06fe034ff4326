#include "core/camera/edge_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Steps this small change nothing that a pixel could show.
constexpr double rest_rad = 2e-6;
constexpr double rest_m = 1e-5;

// What one step may do: association does not reach farther.
constexpr double longest_rad = to_rad(1.5);
constexpr double longest_m = 0.08;

void add_priors(const CameraState& state, const EdgePriors& priors, bool intrinsics, EdgeSums& sums) {
  CameraVector off = prior_offset(priors, state);
  CameraVector sigma = prior_sigma(priors);
  // Held fast where they are.
  if (!intrinsics) {
    off.tail<2>().setZero();
    sigma.tail<2>().setConstant(1e-9);
  }
  const CameraVector weight = sigma.array().square().inverse();
  sums.information.diagonal() += weight;
  sums.gradient += weight.cwiseProduct(off);
}

CameraVector limited(CameraVector step) {
  const double rotation = step.head<3>().norm();
  const double translation = step.segment<3>(3).norm();
  const double factor = std::max({1.0, rotation / longest_rad, translation / longest_m});
  return step / factor;
}

}  // namespace

CameraVector prior_offset(const EdgePriors& priors, const CameraState& state) {
  CameraVector off;
  off << (priors.T_base_camera.inverse() * state.T_base_camera).log(), state.focal_scale, state.k1_change;
  return off;
}

CameraVector prior_sigma(const EdgePriors& priors) {
  CameraVector sigma;
  sigma << Vector3d::Constant(priors.rotation_rad), Vector3d::Constant(priors.translation_m), priors.focal_scale,
      priors.k1;
  return sigma;
}

std::vector<SolveLevel> standard_levels() {
  std::vector<SolveLevel> levels(4);
  const double gates[] = {12.0, 6.0, 4.0, 3.0};
  const double scales[] = {4.0, 2.0, 1.2, 0.7};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].match.gate_px = gates[i];
    levels[i].match.scale_px = scales[i];
    levels[i].intrinsics = i > 0;
    levels[i].look_again = i == 1;
  }
  levels.back().max_iterations = 40;
  return levels;
}

EdgeSums& EdgeSums::operator+=(const EdgeSums& other) {
  gradient += other.gradient;
  information += other.information;
  explained += other.explained;
  segments += other.segments;
  return *this;
}

EdgeSums sum_segments(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                      const MatchOptions& options, std::span<const EdgeView> views) {
  const CameraModel model(changed(intrinsics, state));
  return parallel_sum(views.size(), 1, EdgeSums{}, [&](std::size_t begin, std::size_t) {
    const EdgeView& view = views[begin];
    const CameraAtStop camera = camera_at(model, state, scene.T_G_base[static_cast<std::size_t>(view.stop)]);
    EdgeSums sums;
    for (const SegmentFit& fit : match_view(scene, view, camera, options)) {
      if (fit.samples == 0) continue;
      const double weight = view.weight * fit.information();
      sums.gradient += weight * fit.gradient;
      sums.information += weight * fit.normal;
      sums.explained += view.weight * fit.robust * fit.share();
      sums.segments += view.weight;
    }
    return sums;
  });
}

EdgeSolution solve_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& start,
                         const EdgePriors& priors, std::span<const SolveLevel> levels, std::vector<EdgeView>& views,
                         const RunContext& context) {
  EdgeSolution solution;
  solution.state = start;
  for (const SolveLevel& level : levels) {
    if (level.look_again) find_visible(scene, intrinsics, solution.state, VisibleOptions{}, views);
    solution.converged = false;
    for (int k = 0; k < level.max_iterations && !solution.converged && !context.cancelled(); ++k) {
      EdgeSums sums = sum_segments(scene, intrinsics, solution.state, level.match, views);
      solution.score = sums.score();
      add_priors(solution.state, priors, level.intrinsics, sums);
      solution.information = sums.information;
      const CameraVector step = limited(-sums.information.ldlt().solve(sums.gradient));
      solution.state = moved(solution.state, step);
      ++solution.iterations;
      solution.converged = step.head<3>().norm() < rest_rad && step.segment<3>(3).norm() < rest_m;
    }
  }
  return solution;
}

}  // namespace rigcal
