#pragma once

#include <vector>

#include "core/start/axis_search.h"
#include "core/start/surfel_index.h"

namespace rigcal {

/// All that a LiDAR saw on a turn, in its own frame at angle zero.
struct Panorama {
  AxisTurn turn;
  std::vector<PlacedSurfel> surfels;
};

[[nodiscard]] Panorama make_panorama(const AxisTurn& turn, const std::vector<PatchSurfels>& patches,
                                     const std::vector<SE3>& T_zero_this);

/// Where the other's frame at angle zero may stand in the map's, T_map_other, when both were carried round by the same
/// table: their axes coincide; the angle about it is that at which what stands upright meets best in the plan, the
/// height along it that at which all meets best. The likeliest first.
[[nodiscard]] std::vector<SE3> match_panoramas(const Panorama& map, const Panorama& other);

}  // namespace rigcal
