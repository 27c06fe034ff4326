#pragma once

#include <functional>
#include <vector>

#include "core/start/registration.h"

namespace rigcal {

/// Of each place: from the surfels' own frame, which stands at X, to that of the index.
[[nodiscard]] std::vector<SE3> placed_by(const MovingSurfels& moving, const SE3& X);

/// When a surfel meets one of the index, as in `match_score`.
struct SurfelMatchTolerance {
  double min_cosine = 1.0;
  double max_plane_distance_m = 0.0;
};

/// The poses at which most of the surfels meet one of the index and that stand apart, at most `most`, the best first:
/// the same, to the bit, as `match_score` of every pose and `best_apart` by `near(better, worse)`. Poses that cannot be
/// among them any more are not asked to the end.
[[nodiscard]] std::vector<ScoredPose> best_matches(const SurfelIndex& index, const MovingSurfels& moving,
                                                   const std::vector<SE3>& poses, const SurfelMatchTolerance& tolerance,
                                                   std::size_t most,
                                                   const std::function<bool(const SE3&, const SE3&)>& near);

}  // namespace rigcal
