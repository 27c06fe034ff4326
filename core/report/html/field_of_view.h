#pragma once

#include <vector>

#include "core/rig/rig.h"

namespace rigcal {

/// Unit vectors around the border of what a sensor sees, in its own frame: of a LiDAR by the data sheet of its model,
/// of a camera by its intrinsics, the lens's distortion with them. Empty where it is not known.
[[nodiscard]] std::vector<Vector3d> field_of_view(const Sensor& sensor);

}  // namespace rigcal
