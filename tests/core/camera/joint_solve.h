#pragma once

#include <span>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// The reference of the annealed solver: pose, focal scale, k1 and the shift of every line together on the matches of
/// all views at `start`, by Ceres with one thread. Least squares with matches and weights frozen, in which the annealed
/// solver ends, without its elimination of the shifts.
struct JointSolution {
  CameraState state;
  bool converged = false;
  int iterations = 0;
};

[[nodiscard]] JointSolution solve_jointly(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                          const CameraState& start, const EdgePriors& priors,
                                          const MatchOptions& options, std::span<const EdgeView> views);

}  // namespace rigcal
