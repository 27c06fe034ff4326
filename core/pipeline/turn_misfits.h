#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// Known stops at which the rig stands turned otherwise than the gyro told, by 3 degrees and more against most of the
/// others (and what a gyro's scale may make of the turns between them): little was seen from two of them, and they were
/// laid on each other wrongly. In ascending order; none where fewer than half of the stops agree, since then nobody
/// could say who is right. `R_previous_this`: turns since the stop before, in the frame of the gyro's sensor, of which
/// `T_G_this` are the poses; what follows a turn that nobody told is compared apart.
[[nodiscard]] std::vector<std::size_t> misfit_turns(const std::vector<std::optional<Matrix3d>>& R_previous_this,
                                                    const std::vector<SE3>& T_G_this,
                                                    const std::vector<char>& stop_known);

}  // namespace rigcal
