#pragma once

#include <vector>

#include "core/start/registration.h"

namespace rigcal {

/// Where the base stands at each stop when the rig turned about a fixed point and its rotations are known: T_G_base(j)
/// = (R_j, (I - R_j) f). The foot f (base frame at the first stop; what lies along the axis is left at 0) is found from
/// the base LiDAR's own surfels.
[[nodiscard]] std::vector<SE3> poses_from_rotations(const std::vector<PatchSurfels>& base_patches,
                                                    const std::vector<Matrix3d>& R_G_base);

/// Poses one stop after the other where no gyro was there: each patch is turned about `axis` through the full circle
/// and laid on the stops before it. `base_patches` in the order of stops, one for each; a stop without a patch repeats
/// the pose before it. Scores of the matches go to `scores`.
[[nodiscard]] std::vector<SE3> poses_from_search(const std::vector<PatchSurfels>& base_patches, int stops,
                                                 const Vector3d& axis, std::vector<double>& scores);

}  // namespace rigcal
