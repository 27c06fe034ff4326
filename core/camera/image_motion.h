#pragma once

#include <optional>
#include <vector>

#include "core/camera/camera_calibration.h"

namespace rigcal {

/// The same thing in two images of a camera, by the rays that saw it.
struct SeenTwice {
  double turn_rad = 0.0;  ///< Of the rig about its axis, from `first` to `second`.
  Vector3d first = Vector3d::UnitZ();
  Vector3d second = Vector3d::UnitZ();
};

/// What the images of a camera have in common, the rig having turned by CameraScene::turn. Wrong partners are among
/// them. None where the rig did not turn by enough, or the images show nothing that could be recognised. In the order
/// of the views; deterministic.
[[nodiscard]] std::vector<SeenTwice> match_images(const CameraScene& scene, const CameraTask& camera);

struct CameraAxis {
  Vector3d axis_camera = Vector3d::UnitZ();  ///< The axis of the turn, unit, in the optical frame.
  /// From the axis to the camera, unit, in the optical frame: which way it is carried. How far is not seen, and where
  /// the camera sits on the axis this says nothing.
  Vector3d lever_camera = Vector3d::UnitX();
  double share = 0.0;  ///< Of the pairs, by how well they go with it, 0 .. 1.
};

/// The axis about which the camera must have been turned for what it saw: by a search over all directions. A camera
/// that sits beside the axis is carried as well, towards a side that is found with it: what is near moves by up to some
/// 12 degrees more or less than the turn, along that side (the epipolar constraint, with one rotation for all pairs but
/// for the known angle). Nothing for fewer than 30 pairs.
[[nodiscard]] std::optional<CameraAxis> find_camera_axis(const std::vector<SeenTwice>& pairs);

}  // namespace rigcal
