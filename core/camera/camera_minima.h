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

/// Where edges ended from some start.
struct Minimum {
  EdgeSolution end;
  /// What it is compared by with others: its score, or where views of other things compete that times the root of how
  /// many segments they show, as of few segments many are explained anywhere.
  double worth = 0.0;
};

/// The best of some minima, and the best one that is another.
struct Minima {
  Minimum best;
  std::optional<SE3> runner_up;  ///< Nothing: all are in one.
  double runner_up_ratio = 0.0;  ///< Its worth over the best one's; 1 where nothing explains anything.
};

/// Sorts the minima, of which there is one at least, the best first; those as good stay in their order.
[[nodiscard]] Minima compare_minima(std::vector<Minimum>& minima);

/// An end as the best, and the best one of some others that is in another minimum: 1 where that explains more.
[[nodiscard]] Minima compare_with(const Minimum& end, std::vector<Minimum>& others);

/// Whether one of some others is not where an end is and explains clearly more.
[[nodiscard]] bool is_beaten(const Minimum& end, const std::vector<Minimum>& others);

}  // namespace rigcal
