#pragma once

#include <optional>

#include "core/camera/camera_calibration.h"

namespace rigcal::targetless {

struct MutualInformation {
  SE3 T_base_camera;
  double information = 0.0;  ///< Between reflectivity and grey value at the end, nats.
  int evaluations = 0;
  double match_s = 0.0;  ///< What the camera sees of the map, found anew at each level,
  double solve_s = 0.0;  ///< and the search.
};

/// A camera by mutual information alone (as Pandey et al., AAAI 2012, do it): the pose at which the reflectivity of
/// what the camera sees of the map and the grey value there tell most about each other, in histograms of 16 ranks by 32
/// grey values; the downhill simplex of OpenCV from the guess, on images blurred by 6, 3 and 1 pixels. Nothing where
/// the camera sees none of the map.
[[nodiscard]] std::optional<MutualInformation> maximise_information(const CameraScene& scene, const CameraTask& camera,
                                                                    const SE3& guess_T_base_camera);

}  // namespace rigcal::targetless
