#pragma once

#include <cstddef>
#include <vector>

#include "core/voxel/plane_map.h"

namespace rigcal {

/// Stops of which less than two fifths as much lies on common planes as of the usual one: they stand in the wrong
/// place, or the rig was bumped. In ascending order; of fewer than four stops none, since nobody could say which is
/// usual. Patches without `use` count for nothing.
[[nodiscard]] std::vector<std::size_t> misfit_stops(int stops, const std::vector<PatchCells>& patches,
                                                    const std::vector<char>& use, const PlaneMap& map);

}  // namespace rigcal
