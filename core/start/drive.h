#pragma once

#include <vector>

#include "core/start/surfels.h"

namespace rigcal {

/// Where the base stands at each stop when the rig was driven about and its rotations are known: each patch is laid on
/// all that was seen before it, within 1.5 m (3 m where nothing fits) of the stop before, the likelier the nearer to
/// where the way so far leads. `base_patches` in the order of stops, at most one a stop; `R_G_base` by stop. The first
/// patch stands at the origin; a stop without one, or that meets nothing, stays where the one before it was.
[[nodiscard]] std::vector<SE3> poses_of_drive(const std::vector<PatchSurfels>& base_patches,
                                              const std::vector<Matrix3d>& R_G_base);

}  // namespace rigcal
