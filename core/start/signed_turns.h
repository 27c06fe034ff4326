#pragma once

#include <optional>
#include <vector>

#include "core/geometry/se3.h"

namespace rigcal {

/// By how much something turned about the one axis that it turns about (rad), forth and back with opposite signs: of
/// rotations that are all told in one frame, whichever it is. The axis is where most of them point, and the sum is not
/// negative. Nothing where nothing is told.
[[nodiscard]] std::vector<std::optional<double>> signed_turns(const std::vector<std::optional<Matrix3d>>& R);

}  // namespace rigcal
