#pragma once

#include <span>
#include <vector>

#include "core/camera/edge_matching.h"

namespace rigcal {

/// In the order of the stops, without files. `views` must know what they see.
[[nodiscard]] std::vector<StopAgreement> agreement_of_stops(const CameraScene& scene,
                                                            const CameraIntrinsics& intrinsics,
                                                            const CameraState& state, const MatchOptions& options,
                                                            std::span<const EdgeView> views);

}  // namespace rigcal
