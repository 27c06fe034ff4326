#pragma once

#include "core/camera/camera_calibration.h"

namespace rigcal {

/// How often images of a camera are halved before anything is looked for in them: as long as they have more than two
/// and a half million pixels, and what is left is not coarse. Edges, gates and noise then mean in pixels what they mean
/// in images of the sizes that were tried; 20 million pixels as they come gave sigmas that were a third of the errors.
[[nodiscard]] int halvings_of(const CameraIntrinsics& intrinsics);

/// Of the same camera whose images were halved so often (`halved` of core/edges/grey_image.h).
[[nodiscard]] CameraIntrinsics halved(CameraIntrinsics intrinsics, int times);

/// What was found in halved images, in the pixels of the images as they came, whose intrinsics are `given`.
[[nodiscard]] CameraEstimate at_full_size(CameraEstimate estimate, const CameraIntrinsics& given, int halvings);

}  // namespace rigcal
