#pragma once

#include <vector>

#include "core/camera/camera_calibration.h"

namespace rigcal {

/// Where a camera may sit of which nothing is known, the likeliest first.
struct CameraStarts {
  std::vector<SE3> T_base_camera;
  std::string why_none;  ///< In words for the user, where there is none.
};

/// What its images have in common from stop to stop tells how it is turned towards the axis of the rig's turn; the
/// angle about that axis and the place are then where reflectivity and grey value tell most about each other: a sweep
/// all round, at places up to 1 m beside the axis and 0.7 m along it from the LiDARs. Deterministic whatever the number
/// of threads.
[[nodiscard]] CameraStarts find_camera_starts(const CameraScene& scene, const CameraTask& camera,
                                              const RunContext& context);

}  // namespace rigcal
