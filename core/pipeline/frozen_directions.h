#pragma once

#include "core/pipeline/lidar_result.h"

namespace rigcal {

/// Puts each LiDAR back to where the start laid it by shapes (`adjust.lidar_matches`) along the direction of its place
/// that no surface faces, if there is one: what planes seem to say there is how noise has tilted them. Fills
/// `solution.frozen`; nothing where no LiDAR was laid by shapes.
void freeze_open_directions(LidarSolution& solution);

}  // namespace rigcal
