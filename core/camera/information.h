#pragma once

#include <optional>
#include <vector>

#include "core/camera/camera_calibration.h"

namespace rigcal {

/// A pose with its normalised information distance between reflectivity (with the way a surface faces) and grey value:
/// 1 - I / H, smaller is better.
struct InformationPose {
  SE3 T_base_camera;
  double distance = 1.0;
};

struct InformationSearch {
  InformationPose best;
  std::optional<InformationPose> runner_up;  ///< The best other minimum.
};

/// The basin: rotations around the guess on a grid, the best refined, all under the soft prior of the options. Nothing
/// where too little of the map lies in the images to say anything.
[[nodiscard]] std::optional<InformationSearch> search_information(const CameraScene& scene, const CameraTask& camera,
                                                                  const SE3& guess_T_base_camera,
                                                                  const CameraCalibrationOptions& options,
                                                                  const RunContext& context);

/// The optimum near `start_T_base_camera` at full sharpness, with its covariance (its ripples included). Nothing where
/// it runs away, too little is seen, or what is seen tells nothing of the grey values. `model` may have other
/// intrinsics than the camera's.
[[nodiscard]] std::optional<PoseEstimate> refine_information(const CameraScene& scene, const CameraTask& camera,
                                                             const CameraIntrinsics& intrinsics,
                                                             const SE3& start_T_base_camera, const RunContext& context);

}  // namespace rigcal
