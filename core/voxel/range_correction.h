#pragma once

#include "core/voxel/cells.h"

namespace rigcal {

/// The patch as a LiDAR sees it whose ranges are shorter by `offset_m` (longer where it is negative): cells and thinned
/// points move along their rays.
void shorten_ranges(PatchCells& patch, double offset_m);

}  // namespace rigcal
