#pragma once

#include <optional>
#include <vector>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// Whether two poses are no farther apart than a turn and a way.
[[nodiscard]] bool is_within(const SE3& a, const SE3& b, double rotation_rad, double translation_m);

/// Whether two poses are in one minimum: no farther apart than `share` of what tells minima apart, 0.2 degrees and 3
/// cm.
[[nodiscard]] bool is_same_minimum(const CameraState& a, const CameraState& b, double share);

/// The best of some ends, and the best one in another minimum.
struct Minima {
  EdgeSolution best;
  std::optional<SE3> runner_up;  ///< Nothing: all are in one.
  double runner_up_ratio = 0.0;  ///< Its score over the best one's; 1 where nothing explains anything.
};

/// Sorts the solutions, of which there is one at least, the best first; those as good stay in their order.
[[nodiscard]] Minima compare_minima(std::vector<EdgeSolution>& solutions);

}  // namespace rigcal
