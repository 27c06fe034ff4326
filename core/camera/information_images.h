#pragma once

#include <vector>

#include "core/camera/camera_calibration.h"
#include "core/camera/smooth_image.h"

namespace rigcal {

/// What an image of the information distance shows of its view.
enum class Shown {
  brightness,  ///< The image as it is: for the basin, to which shading and large surfaces lead.
  contrast     ///< Less the brightness of the surroundings: for the fine end, from which they would lead away.
};

/// The views of a camera as InformationCost reads them, `halvings` smaller. The grey values of each image are
/// spread over 0 .. grey_levels - 1, so that its exposure does not matter. Views that cannot be used are plain.
[[nodiscard]] std::vector<SmoothImage> information_images(const CameraScene& scene, const CameraTask& camera,
                                                          int halvings, Shown shown);

}  // namespace rigcal
