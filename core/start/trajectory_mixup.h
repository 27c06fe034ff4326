#pragma once

#include <optional>
#include <vector>

#include "core/start/surfels.h"

namespace rigcal {

/// How poses are often written down wrongly.
enum class TrajectoryMixup { none, inverse, w_first, millimetres };

/// Whether what the base saw from its stops lies on each other clearly better if the given poses are taken otherwise.
/// `base`: the LiDAR of `patches` that they are poses of; `T_G_base`: by stop, as they were read.
[[nodiscard]] TrajectoryMixup trajectory_mixup(const std::vector<PatchSurfels>& patches, int base,
                                               const std::vector<std::optional<SE3>>& T_G_base);

/// The same as a sentence with its mend; empty for none.
[[nodiscard]] const char* to_words(TrajectoryMixup mixup);

}  // namespace rigcal
