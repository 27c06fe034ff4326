#pragma once

#include <string>
#include <vector>

#include "core/quality/result_evidence.h"
#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// How thick the planes are that two LiDARs both see, at `before` and at `after`: by how much the one's mean stands off
/// the other's along the plane's normal, each plane weighted by how well both means are known. A pair a line, then all
/// pairs together; nothing where no plane is shared. `names` has an entry for each LiDAR. Merged planes do not count:
/// they are leaves that are already there.
[[nodiscard]] std::vector<SharedSurfaces> shared_surfaces(const std::vector<PlaneFeature>& features,
                                                          const RigState& before, const RigState& after,
                                                          const std::vector<std::string>& names);

/// The plane's normal at `state`, from what all its observers saw.
[[nodiscard]] Vector3d plane_normal(const PlaneFeature& feature, const RigState& state);

}  // namespace rigcal
