#pragma once

#include <vector>

#include "core/voxel/plane_feature.h"

namespace rigcal {

struct MergeOptions {
  double tolerance_m = 0.005;  ///< Leaves' middles within this of a plane are on it.
  double max_normal_angle_rad = to_rad(3.0);
  double block_m = 2.0;            ///< Unevenness is taken as one over blocks of this size.
  double min_flatness_m = 0.0005;  ///< No wall is flatter.
  double max_extent_m = 40.0;
};

/// Planes larger than a voxel: leaves that lie on one physical plane, as further features beside the leaves. A rig that
/// turns in place sees every wall from one side only, so small planes leave its tilt against the axis nearly open (the
/// world may bend into a cone); that a floor is flat across the whole room closes it. How flat is taken from the leaves
/// themselves: each block of a merged plane weighs no more than one measurement with the spread of the leaves around
/// it. Planes of fewer than four leaves are left alone. The leaves are told how much of them counts
/// twice now (`counted_again`). Deterministic.
[[nodiscard]] std::vector<PlaneFeature> merge_coplanar(std::vector<PlaneFeature>& leaves, const MergeOptions& options);

}  // namespace rigcal
