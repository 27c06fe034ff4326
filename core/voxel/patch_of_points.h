#pragma once

#include <span>

#include "core/geometry/se3.h"
#include "core/voxel/cells.h"

namespace rigcal {

/// What a LiDAR saw at a stop, from bare places in its frame (m), as `CellBuilder` makes it.
[[nodiscard]] PatchCells patch_of_points(std::span<const Vector3d> points, int lidar, int stop,
                                         const CellOptions& options);

}  // namespace rigcal
