#pragma once

#include <vector>

#include "core/start/surfels.h"

namespace rigcal {

/// Where the base stands at each stop when the rig turned about a fixed point and its rotations are known: T_G_base(j)
/// = (R_j, (I - R_j) f). The foot f (base frame at the first stop; what lies along the axis is left at 0) is found from
/// the base LiDAR's own surfels.
[[nodiscard]] std::vector<SE3> poses_from_rotations(const std::vector<PatchSurfels>& base_patches,
                                                    const std::vector<Matrix3d>& R_G_base);

}  // namespace rigcal
