#pragma once

#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/camera/smooth_image.h"

namespace rigcal {

/// The views of a camera as InformationCost reads them, `halvings` smaller. The grey values of each image are
/// spread over 0 .. grey_levels - 1, so that its exposure does not matter. Views that cannot be used are plain.
[[nodiscard]] std::vector<SmoothImage> information_images(const CameraScene& scene, const CameraTask& camera,
                                                          int halvings);

}  // namespace rigcal
