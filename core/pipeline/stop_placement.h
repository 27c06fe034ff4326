#pragma once

#include <optional>
#include <vector>

#include "core/start/rig_start.h"

namespace rigcal {

/// A calibration that has seen some stops, before the next one is added.
struct PlacementInput {
  const Start& solved;                              ///< What is known, and where.
  const std::vector<PatchSurfels>& surfels;         ///< Of all patches so far and of the new stop.
  int stop = 0;                                     ///< The new one; those before it are in `solved`.
  Matrix3d R_previous_this = Matrix3d::Identity();  ///< From the stop before, by the gyro.
};

/// T_G_base at the new stop, good to a few centimetres: turned by the gyro about the line that the rig has turned about
/// so far, then all that it saw there laid on all that was seen before. Nothing where too little of it fits.
[[nodiscard]] std::optional<SE3> place_stop(const PlacementInput& input);

}  // namespace rigcal
