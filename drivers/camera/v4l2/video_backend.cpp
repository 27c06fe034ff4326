#include "drivers/camera/v4l2/video_backend.h"

#include "drivers/camera/v4l2/video_camera.h"

namespace rigcal::camera {

Expected<std::vector<CameraIdentity>> VideoBackend::enumerate() {
  std::vector<CameraIdentity> cameras;
  for (const std::string& path : kernel_->devices()) {
    // Those that may not be opened are named when somebody asks for one of them.
    if (auto opened = open_video(kernel_, path)) cameras.push_back(opened->identity);
  }
  return cameras;
}

std::unique_ptr<Camera> VideoBackend::make() { return make_video_camera(kernel_); }

}  // namespace rigcal::camera
