#pragma once

#include "core/camera/edge_solver.h"

namespace rigcal {

/// A lens of the other distortion model with the same focal length and principal point, without distortion of its own.
[[nodiscard]] CameraIntrinsics other_lens(const CameraIntrinsics& intrinsics);

/// How many times more of its edges the other lens explains than the one of the camera does where it ended: near 1 and
/// below it says nothing against the camera's. The pose, focal length and k1 of the other are found around `priors`.
/// Changes what the views see.
[[nodiscard]] double other_lens_gain(const CameraScene& scene, const CameraIntrinsics& intrinsics,
                                     const CameraState& end, const EdgePriors& priors, std::vector<EdgeView>& views,
                                     const RunContext& context);

}  // namespace rigcal
