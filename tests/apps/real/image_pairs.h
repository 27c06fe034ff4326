#pragma once

#include <filesystem>
#include <vector>

#include "core/rig/camera_model.h"

namespace rigcal {

/// A point that two cameras see: unit rays in either camera's frame.
struct RayPair {
  Vector3d first;
  Vector3d second;
};

/// Points that two images show alike (SIFT, the nearest both ways and clearly so) and that agree with one epipolar
/// geometry to a pixel, whichever. Nothing of an extrinsic goes in.
[[nodiscard]] std::vector<RayPair> match_images(const std::filesystem::path& first, const CameraModel& first_camera,
                                                const std::filesystem::path& second, const CameraModel& second_camera);

/// Median distance, in pixels of a camera with this focal length, of the points from the epipolar lines that the pose
/// of the cameras to each other gives.
[[nodiscard]] double median_epipolar_px(const std::vector<RayPair>& pairs, const SE3& T_second_first, double focal_px);

/// The same for the epipolar geometry that fits these pairs best: what the images alone allow.
[[nodiscard]] double least_epipolar_px(const std::vector<RayPair>& pairs, double focal_px);

}  // namespace rigcal
