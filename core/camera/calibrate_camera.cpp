#include "core/camera/camera_calibration.h"

namespace rigcal {

Expected<CameraEstimate> calibrate_camera(const CameraScene& scene, const CameraTask& camera,
                                          const CameraCalibrationOptions& /*options*/, const RunContext& /*context*/) {
  CameraEstimate estimate;
  estimate.why_not = std::to_string(camera.views.size()) + " images and " + std::to_string(scene.edges.size()) +
                     " LiDAR edge points were read, but this build does not match them yet";
  estimate.views = static_cast<int>(camera.views.size());
  return estimate;
}

}  // namespace rigcal
