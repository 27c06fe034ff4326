#pragma once

#include <optional>
#include <vector>

#include "core/start/registration.h"

namespace rigcal {

struct FoundTurns {
  std::vector<Matrix3d>
      R_G_base;             ///< By stop; the first is the identity, one that is not found repeats the one before.
  std::vector<char> found;  ///< By stop: whether it hangs together with most of those that have a patch.
};

/// How the rig is turned at each stop where no gyro was there and steps need not be equal: slower than
/// `rotations_from_search`, which is right more often where they are. Each patch is turned about `axis` (unit, base
/// frame) through the full circle and laid on the one before it, or, where that shows nothing, on one of the two before
/// that, where most lies on what was seen from there and least contradicts it. Where three quarters of the steps that
/// are clear are alike, one like them is preferred. `base_patches` in the order of stops, at most one for each;
/// `R_previous_this`: steps that are known, empty or one for each stop.
[[nodiscard]] FoundTurns rotations_by_evidence(const std::vector<PatchSurfels>& base_patches, int stops,
                                               const Vector3d& axis,
                                               const std::vector<std::optional<Matrix3d>>& R_previous_this);

}  // namespace rigcal
