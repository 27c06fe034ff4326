#pragma once

#include <vector>

#include "core/camera/edge_solver.h"

namespace rigcal {

struct EdgeSearchOptions {
  double reach_rad = to_rad(6.0);  ///< Rotations so far from the centre, about each axis,
  double step_rad = to_rad(1.2);   ///< on a grid like this.
  double apart_rad = to_rad(2.0);  ///< Minima that lie nearer are one.
  double finest_px = 8.0;          ///< Nearness is asked at 8 px first, then at half of it down to this.
  int starts = 3;                  ///< How many are wanted.
  std::size_t samples = 3000;      ///< Of all views together, at most.
};

/// Where the solver may start: rotations around `centre` on a grid, scored by how near long image edges of the right
/// direction are to the projected ones; the best are followed uphill, the translation with them under the prior, and
/// sorted, the best first. `views` must know what they see, beyond the image's border too.
[[nodiscard]] std::vector<SE3> search_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                            const SE3& centre_T_base_camera, const EdgePriors& priors,
                                            const std::vector<EdgeView>& views, const EdgeSearchOptions& options);

}  // namespace rigcal
