#pragma once

#include <vector>

#include "core/camera/edge_solver.h"

namespace rigcal {

/// Where the solver may start: rotations around `centre` on a grid, scored by how near long image edges of the right
/// direction are to the projected ones; the best are followed uphill, the translation with them under the prior, and
/// sorted, the best first. `views` must know what they see, beyond the image's border too. Nearness is asked at 8 px
/// first, then at half of it down to `finest_px`.
[[nodiscard]] std::vector<SE3> search_edges(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                            const SE3& centre_T_base_camera, const EdgePriors& priors,
                                            const std::vector<EdgeView>& views, double finest_px = 8.0);

}  // namespace rigcal
