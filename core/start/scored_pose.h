#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// A pose and how well it fits: the share of what was seen that lies where it should.
struct ScoredPose {
  SE3 X;
  double score = 0.0;
};

/// Whether two poses are distinctly others: more than 0.3 m or 3 degrees apart.
[[nodiscard]] inline bool distinct(const SE3& a, const SE3& b) {
  return (a.t - b.t).norm() > 0.3 || rotation_distance(a.R, b.R) > to_rad(3.0);
}

/// For `best_apart`.
[[nodiscard]] inline bool is_same(const ScoredPose& a, const ScoredPose& b) { return !distinct(a.X, b.X); }

}  // namespace rigcal
