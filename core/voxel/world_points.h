#pragma once

#include <vector>

#include "core/voxel/cells.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// The thinned points of a patch in the world, in their order.
[[nodiscard]] std::vector<Eigen::Vector3f> world_points(const PatchCells& patch, const RigState& state);

/// Every `every`-th of them, the first one first, behind what is in `world`.
void append_world_points(const PatchCells& patch, const RigState& state, std::size_t every,
                         std::vector<Eigen::Vector3f>& world);

}  // namespace rigcal
