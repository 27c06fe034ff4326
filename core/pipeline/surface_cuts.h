#pragma once

#include <vector>

#include "core/quality/result_evidence.h"
#include "core/voxel/cells.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// Up to three surfaces that most LiDARs see, each facing another way, cut open at `before` and at `after`: the thinned
/// points of all patches with `use` within 15 cm of a line across it, at most `max_dots` of each. The cuts are as deep
/// as the points stood off at `before` (at most 0.75 m); one in which nothing lies then is left out. `sensor_of[lidar]`
/// is the sensor's index in the rig.
[[nodiscard]] std::vector<SurfaceCut> cut_surfaces(const std::vector<PlaneFeature>& features,
                                                   const std::vector<PatchCells>& patches, const RigState& before,
                                                   const RigState& after, const std::vector<char>& use,
                                                   const std::vector<int>& sensor_of, std::size_t max_dots = 4000);

}  // namespace rigcal
