#pragma once

#include <vector>

#include "core/voxel/plane_feature.h"

namespace rigcal {

struct MergeOptions {
  double tolerance_m = 0.005;  ///< Leaves' middles within this of a plane are on it.
  /// Takes what noise explains off what leaves stand off, down to 0.1 mm; else all that they stand off is unevenness,
  /// and more. For units whose ranges have shown no error of their own: such an error bends all walls alike, and leaves
  /// of one wall agree in it.
  bool trust_noise = false;
};

/// Planes larger than a voxel: leaves that lie on one physical plane, as further features beside the leaves. A rig that
/// turns in place sees every wall from one side only, so small planes leave its tilt against the axis nearly open (the
/// world may bend into a cone); that a floor is flat across the whole room closes it. How flat is taken from the leaves
/// themselves: each block of a merged plane weighs no more than one measurement with the spread of the leaves around
/// it. Planes of fewer than four leaves are left alone. What a merged plane takes over of a leaf (`merged_share`) its
/// observations weigh less, so that nothing counts twice. Deterministic.
[[nodiscard]] std::vector<PlaneFeature> merge_coplanar(std::vector<PlaneFeature>& leaves, const MergeOptions& options);

}  // namespace rigcal
