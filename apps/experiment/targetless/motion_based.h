#pragma once

#include <optional>
#include <vector>

#include "apps/experiment/targetless/icp.h"

namespace rigcal::targetless {

/// Hand-eye calibration: X with A X = X B for the motions A and B of base and sensor between poses up to six apart.
/// OpenCV's closed form (Park and Martin 1994) and a dozen turns about the main axis are the starts, each refined by
/// least squares on rotations and translations together; the best of them. `T_world_base` and `T_other_sensor` are the
/// poses of both at the same moments, each in a world of its own. Nothing with fewer than three poses. What turns about
/// one axis leave open (the place along it) is anything.
[[nodiscard]] std::optional<SE3> hand_eye(const std::vector<SE3>& T_world_base, const std::vector<SE3>& T_other_sensor);

/// LiDARs by their motions alone: the scans of each are registered with each other by `icp` from rough poses (by LiDAR,
/// then by stop; of the LiDAR itself, in its own frame at the first stop), without any scan of another LiDAR; then
/// hand-eye. The base's place is the identity; nothing for one that cannot be told.
[[nodiscard]] std::vector<std::optional<SE3>> place_by_motion(PairwiseIcp& icp, int base,
                                                              const std::vector<std::vector<SE3>>& rough,
                                                              const RunContext& context);

}  // namespace rigcal::targetless
