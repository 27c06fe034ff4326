#pragma once

#include <span>
#include <string>
#include <vector>

#include "core/camera/camera_calibration.h"

namespace rigcal {

/// The views, each as if it were of the stop `by` places after its own; without those for which there is no such stop,
/// or no pose of it (0 in `stop_known`).
[[nodiscard]] std::vector<CameraView> views_moved(std::span<const CameraView> views, int by,
                                                  const std::vector<char>& stop_known);

/// Of images that fit where they are moved so, and not where they are: why not good, and the mend. `by` is -1 or 1.
[[nodiscard]] std::string wrong_stops_words(int by);

}  // namespace rigcal
