#pragma once

#include <span>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// What a camera was solved with.
struct SolvedCamera {
  const CameraScene& scene;
  const CameraTask& camera;
  const EdgePriors& priors;
  const SolveLevel& level;  ///< The last one.
  const std::vector<EdgeView>& views;
};

/// Solves again without every fourth stop, for either half of the stops, and for the first and the last of them, from
/// the end of all, and fills in what that tells of an estimate: hold-out, halves, first and last. What there are too
/// few stops for stays as it is.
void check_by_stops(const SolvedCamera& solved, const EdgeSolution& end, const RunContext& context,
                    CameraEstimate& estimate);

}  // namespace rigcal
