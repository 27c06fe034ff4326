#pragma once

#include <vector>

#include "core/voxel/cells.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// Every `every`-th of a patch's thinned points in the world, the first one first, behind what is in `world`.
void append_world_points(const PatchCells& patch, const RigState& state, std::size_t every,
                         std::vector<Eigen::Vector3f>& world);

}  // namespace rigcal
