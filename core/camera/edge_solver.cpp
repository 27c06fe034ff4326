#include "core/camera/edge_solver.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"

namespace rigcal {
namespace {

// Steps this small change nothing that a pixel could show.
constexpr double rest_rad = 4e-6;
constexpr double rest_m = 2e-5;
// Nor does one that is so small a share of what the pose is known to.
constexpr double rest_sigmas = 0.01;

// So many steps of a level are taken in full, and after each so many more by half of what they were.
constexpr int undamped_steps = 12;
constexpr int halving_steps = 12;
// Steps that were made small have not ended by that: where matches only come and go, the full ones are this small.
constexpr double restless_sigmas = 0.5;

// What one step may do: association does not reach farther.
constexpr double longest_rad = to_rad(1.5);
constexpr double longest_m = 0.08;

// Sigmas of what is held fast.
constexpr double fast = 1e-9;
constexpr double fast_px = 1e-6;

void add_priors(const CameraState& state, const EdgePriors& priors, bool intrinsics, EdgeSums& sums) {
  CameraVector off = prior_offset(priors, state);
  CameraVector sigma = prior_sigma(priors);
  // Held fast where they are.
  if (!intrinsics) {
    off.tail<lens_parameters>().setZero();
    sigma.segment<2>(pose_parameters).setConstant(fast);
    sigma.tail<2>().setConstant(fast_px);
  }
  const CameraVector weight = sigma.array().square().inverse();
  sums.information.diagonal() += weight;
  sums.gradient += weight.cwiseProduct(off);
}

// All segments of one line, in all views.
struct LineSums {
  double variance = 0.0;
  double segments = 0.0;
  CameraVector gradient = CameraVector::Zero();
  CameraMatrix normal = CameraMatrix::Zero();
  Vector3d shift_gradient = Vector3d::Zero();
  Matrix3d shift_normal = Matrix3d::Zero();
  Eigen::Matrix<double, camera_parameters, 3> mixed = Eigen::Matrix<double, camera_parameters, 3>::Zero();

  void add(const SegmentFit& fit, double weight) {
    variance += fit.line_variance;
    segments += 1.0;
    gradient += weight * fit.gradient;
    normal += weight * fit.normal;
    shift_gradient += weight * fit.shift_gradient;
    shift_normal += weight * fit.shift_normal;
    mixed += weight * fit.mixed;
  }

  // The line is off by an unknown shift, the same in all views; it is eliminated.
  void add_without_shift(EdgeSums& sums) const {
    const Matrix3d A = shift_normal + segments / variance * Matrix3d::Identity();
    const Eigen::Matrix<double, camera_parameters, 3> gain = A.ldlt().solve(mixed.transpose()).transpose();
    sums.gradient += gradient - gain * shift_gradient;
    sums.information += normal - gain * mixed.transpose();
  }
};

CameraVector limited(CameraVector step) {
  const double rotation = step.head<3>().norm();
  const double translation = step.segment<3>(3).norm();
  const double factor = std::max({1.0, rotation / longest_rad, translation / longest_m});
  return step / factor;
}

}  // namespace

std::vector<SolveLevel> quick_levels() {
  std::vector<SolveLevel> levels = standard_levels();
  for (SolveLevel& level : levels) {
    level.max_iterations = 6;
    level.intrinsics = false;
  }
  return levels;
}

CameraVector prior_offset(const EdgePriors& priors, const CameraState& state) {
  CameraVector off;
  off << (priors.T_base_camera.inverse() * state.T_base_camera).log(), state.focal_scale, state.k1_change,
      state.principal_change_px;
  return off;
}

CameraVector prior_sigma(const EdgePriors& priors) {
  CameraVector sigma;
  sigma << Vector3d::Constant(priors.rotation_rad), Vector3d::Constant(priors.translation_m), priors.focal_scale,
      priors.k1, Eigen::Vector2d::Constant(std::max(priors.principal_px, fast_px));
  return sigma;
}

std::vector<SolveLevel> standard_levels() {
  std::vector<SolveLevel> levels(4);
  const double gates[] = {12.0, 6.0, 4.0, 2.0};
  const double scales[] = {4.0, 2.0, 1.2, 0.4};
  for (std::size_t i = 0; i < levels.size(); ++i) {
    levels[i].match.gate_px = gates[i];
    levels[i].match.scale_px = scales[i];
    levels[i].intrinsics = i > 0;
  }
  levels.back().max_iterations = 80;
  return levels;
}

EdgeSums sum_segments(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& state,
                      const MatchOptions& options, std::span<const EdgeView> views) {
  const CameraModel model(changed(intrinsics, state));
  std::vector<std::vector<SegmentFit>> fits(views.size());
  parallel_for(views.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const SE3& T_G_base = scene.T_G_base[static_cast<std::size_t>(views[k].stop)];
      fits[k] = match_view(scene, views[k], camera_at(model, state, T_G_base), options);
    }
  });
  EdgeSums sums;
  std::map<int, LineSums> lines;
  for (std::size_t k = 0; k < views.size(); ++k) {
    for (const SegmentFit& fit : fits[k]) {
      if (fit.samples == 0) continue;
      sums.explained += views[k].weight * fit.explained();
      sums.segments += views[k].weight;
      lines[fit.line].add(fit, views[k].weight * fit.information());
    }
  }
  for (const auto& [line, line_sums] : lines) line_sums.add_without_shift(sums);
  return sums;
}

EdgeSolution solve_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics, const CameraState& start,
                         const EdgePriors& priors, std::span<const SolveLevel> levels, std::span<const EdgeView> views,
                         const RunContext& context) {
  EdgeSolution solution;
  solution.state = start;
  for (const SolveLevel& level : levels) {
    solution.converged = false;
    for (int k = 0; k < level.max_iterations && !solution.converged && !context.cancelled(); ++k) {
      EdgeSums sums = sum_segments(scene, intrinsics, solution.state, level.match, views);
      solution.score = sums.score();
      add_priors(solution.state, priors, level.intrinsics, sums);
      solution.information = sums.information;
      CameraVector step = limited(-sums.information.ldlt().solve(sums.gradient));
      if (priors.principal_px <= 0.0) step.tail<2>().setZero();  // What is given stays as it is, to the last bit.
      const double full = std::sqrt(step.dot(sums.information * step));
      // Matches that change with the pose may pull it to and fro: ever smaller steps settle between.
      const double share = k < undamped_steps ? 1.0 : std::exp2(-1 - (k - undamped_steps) / halving_steps);
      step *= share;
      solution.state = moved(solution.state, step);
      ++solution.iterations;
      const bool rests = step.head<3>().norm() < rest_rad && step.segment<3>(3).norm() < rest_m;
      solution.converged = (rests || share * full < rest_sigmas) && full < restless_sigmas;
    }
  }
  return solution;
}

}  // namespace rigcal
