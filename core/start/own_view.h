#pragma once

#include <vector>

#include "core/start/surfel_index.h"
#include "core/start/surfels.h"

namespace rigcal {

/// The surfels of one patch, to be asked for in its own frame.
[[nodiscard]] SurfelIndex index_of(const PatchSurfels& patch, double reach_m);

/// Weights that let every direction count the same, however many of the surfaces face it: n^T (sum n n^T)^-1 n, over
/// their sum.
[[nodiscard]] std::vector<double> balanced_weights(const std::vector<Vector3d>& normals);

/// Share of the surfels of one LiDAR that lie on what it saw from other stops, where it stood at `poses` (by stop):
/// within 6 cm and 14 degrees. All count the same, or in balanced weights.
[[nodiscard]] double agreement(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& poses);
[[nodiscard]] double balanced_agreement(const std::vector<PatchSurfels>& patches, const std::vector<SE3>& poses);

}  // namespace rigcal
