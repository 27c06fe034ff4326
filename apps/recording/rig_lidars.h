#pragma once

#include <optional>
#include <vector>

#include "core/rig/rig.h"

namespace rigcal {

/// The sensors of the rig that are LiDARs, in the order of their names: how the calibration numbers them. Not in that
/// of the rig file, which would decide who is placed first and is no fact of the rig.
[[nodiscard]] std::vector<int> lidar_sensors(const Rig& rig);
/// Their guesses as the rig file has them; the base's is the identity.
[[nodiscard]] std::vector<std::optional<SE3>> lidar_guesses(const Rig& rig);

}  // namespace rigcal
