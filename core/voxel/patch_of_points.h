#pragma once

#include <span>
#include <vector>

#include "core/geometry/se3.h"
#include "core/records/records.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// What a LiDAR saw at a stop, from bare places in its frame (m), as `CellBuilder` makes it.
[[nodiscard]] PatchCells patch_of_points(std::span<const Vector3d> points, int lidar, int stop,
                                         const CellOptions& options);

/// The cells of whole patches, in their order; in parallel.
[[nodiscard]] std::vector<PatchCells> cells_of_patches(std::span<const Patch> patches, const CellOptions& options);

}  // namespace rigcal
