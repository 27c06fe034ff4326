#pragma once

#include "core/report/result_formats.h"

/// The writers behind `export_result`, a function a format. All transforms are 64 bit floats that read back to the same
/// bits.
namespace rigcal {

/// A sensor that has a transform, with what the rig file knows of it.
struct PlacedSensor {
  std::string name;
  SE3 T_base_sensor;
  bool is_camera = false;
  const CameraIntrinsics* intrinsics = nullptr;
  std::string topic;  ///< Of a camera's images in bags; may be empty.
};

struct PlacedRig {
  std::string base;
  std::vector<PlacedSensor> sensors;  ///< The base included.
};

// Trees of frames: result_frames.cpp.
[[nodiscard]] std::string ros2_launch(const PlacedRig& rig);
[[nodiscard]] std::string urdf(const PlacedRig& rig);
[[nodiscard]] std::string autoware_yaml(const PlacedRig& rig);

// Cameras and matrices: result_vision.cpp. Of the first two the sensors are those that the format is about.
[[nodiscard]] std::string kalibr_yaml(const PlacedRig& rig, std::vector<std::string>& warnings);
[[nodiscard]] std::string colmap_json(const PlacedRig& rig);
[[nodiscard]] std::string opencv_yaml(const PlacedRig& rig);

// Blocks for the configuration of LiDAR odometry: result_odometry.cpp.
[[nodiscard]] std::string fast_livo_yaml(const PlacedRig& rig);

// Bare numbers: result_lists.cpp.
[[nodiscard]] std::string mlcc_lines(const PlacedRig& rig);

// All of it as JSON: result_json.cpp.
[[nodiscard]] std::string result_json(const CalibrationResult& result, const PlacedRig& placed);

}  // namespace rigcal
