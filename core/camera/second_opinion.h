#pragma once

#include "core/camera/camera_calibration.h"
#include "core/camera/camera_state.h"

namespace rigcal {

/// Reflectivity and grey value know nothing of edges: where both agree within their sigmas, both are right. Fills in
/// `information` and `disagreement_chi2` of an estimate whose pose is what edges told, with the intrinsics of `state`.
/// Where the edges are weak and nothing speaks against them, the pose becomes what both together tell.
void ask_second_opinion(const CameraScene& scene, const CameraTask& camera, const CameraState& state,
                        const RunContext& context, CameraEstimate& estimate);

}  // namespace rigcal
