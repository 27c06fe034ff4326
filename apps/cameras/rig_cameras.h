#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/rig/rig.h"
#include "drivers/camera/camera.h"

namespace rigcal {

/// Images a second of cameras that are triggered, where the rig file does not say: one or more in each stop, and little
/// to pack.
constexpr double usual_image_rate = 2.0;

/// A camera of the rig that can be taken live.
struct RigCamera {
  std::string sensor;
  std::string driver;  ///< aravis or v4l2.
  std::string device;
  camera::CameraConfig config;
  std::optional<std::array<int, 2>> size;  ///< Of the images that its intrinsics are for.
  bool is_told = false;                    ///< It is triggered by software: for each image it has to be told.
  bool has_pulses = false;                 ///< It waits for pulses, and the rig has a line of its own that gives them.
};

/// Those whose driver reaches a device, set up as the rig file says.
[[nodiscard]] std::vector<RigCamera> rig_cameras(const Rig& rig);

/// Ways to the cameras of a rig, by the names of its file.
class CameraDrivers {
 public:
  /// `settings_folder`: see camera::AravisOptions.
  explicit CameraDrivers(const std::string& settings_folder);
  explicit CameraDrivers(std::vector<std::unique_ptr<camera::CameraBackend>> backends)
      : backends_(std::move(backends)) {}

  /// "aravis" or "v4l2".
  [[nodiscard]] std::unique_ptr<camera::Camera> make(const std::string& driver);
  /// All that any of them sees.
  [[nodiscard]] std::vector<camera::CameraIdentity> enumerate();

 private:
  std::vector<std::unique_ptr<camera::CameraBackend>> backends_;
};

/// Opens it and sets it up, as the rig file says. Errors name the sensor.
[[nodiscard]] Expected<camera::CameraSetup> prepare(camera::Camera& opened, const RigCamera& wanted);

/// Where this user's programs keep what they would miss after a crash; empty where the system does not say.
[[nodiscard]] std::string camera_settings_folder();

}  // namespace rigcal
