#pragma once

#include <span>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// Pose, focal scale and k1 together on the matches of all views at `start`, by Ceres with one thread: least squares
/// with matches and weights frozen, which is what the annealed solver ends in, and its covariance.
struct JointSolution {
  CameraState state;
  CameraMatrix covariance = CameraMatrix::Zero();  ///< Of the state's parameters; priors included.
  bool converged = false;
  int iterations = 0;
};

[[nodiscard]] JointSolution solve_jointly(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                          const CameraState& start, const EdgePriors& priors,
                                          const MatchOptions& options, std::span<const EdgeView> views);

}  // namespace rigcal
