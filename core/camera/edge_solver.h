#pragma once

#include <span>

#include "core/camera/edge_matching.h"

namespace rigcal {

/// What the solver holds on to where edges say nothing.
struct EdgePriors {
  SE3 T_base_camera;
  double rotation_rad = to_rad(6.0);
  double translation_m = 0.12;
  double focal_scale = 0.002;
  double k1 = 0.005;
  double principal_px = 0.0;  ///< 0: it is where the rig file says.
};

/// How far a state is from them, and their sigmas, in the order of the parameters.
[[nodiscard]] CameraVector prior_offset(const EdgePriors& priors, const CameraState& state);
[[nodiscard]] CameraVector prior_sigma(const EdgePriors& priors);

/// Matching gets finer from level to level.
struct SolveLevel {
  MatchOptions match;
  bool intrinsics = true;  ///< Of the lens: free, under their priors.
  int max_iterations = 12;
};

/// From a start that is 12 px off to the end.
[[nodiscard]] std::vector<SolveLevel> standard_levels();
/// The same in fewer steps, to compare starts: where minima are told apart, not where they are exact.
[[nodiscard]] std::vector<SolveLevel> quick_levels();

struct EdgeSolution {
  CameraState state;
  CameraMatrix information = CameraMatrix::Zero();  ///< Of the state's parameters, priors included.
  double score = 0.0;                               ///< Share of the segments that image edges explain, 0 .. 1.
  bool converged = false;
  int iterations = 0;
};

/// Sums of all segments at a state, the lines' own shifts eliminated; `score` as in EdgeSolution.
struct EdgeSums {
  CameraVector gradient = CameraVector::Zero();
  CameraMatrix information = CameraMatrix::Zero();
  double explained = 0.0;
  double segments = 0.0;

  [[nodiscard]] double score() const { return segments > 0.0 ? explained / segments : 0.0; }
};

[[nodiscard]] EdgeSums sum_segments(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                    const CameraState& state, const MatchOptions& options,
                                    std::span<const EdgeView> views);

/// Gauss-Newton on the balanced segments of all views, matched anew at each step. `views` must know what they see.
[[nodiscard]] EdgeSolution solve_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                       const CameraState& start, const EdgePriors& priors,
                                       std::span<const SolveLevel> levels, std::span<const EdgeView> views,
                                       const RunContext& context);

}  // namespace rigcal
