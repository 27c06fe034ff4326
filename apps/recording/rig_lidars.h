#pragma once

#include <optional>
#include <vector>

#include "core/rig/rig.h"

namespace rigcal {

/// The sensors of the rig that are LiDARs, in its order: how the calibration numbers them.
[[nodiscard]] std::vector<int> lidar_sensors(const Rig& rig);
/// Their guesses as the rig file has them; the base's is the identity.
[[nodiscard]] std::vector<std::optional<SE3>> lidar_guesses(const Rig& rig);

}  // namespace rigcal
