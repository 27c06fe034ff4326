#pragma once

#include <memory>
#include <string>

#include "drivers/camera/camera.h"
#include "drivers/camera/v4l2/video_device.h"

namespace rigcal::camera {

struct OpenVideo {
  std::shared_ptr<const VideoDevice> device;
  CameraIdentity identity;
};
/// Errors: no such file, no right to open it, no camera.
[[nodiscard]] Expected<OpenVideo> open_video(const std::shared_ptr<VideoKernel>& kernel, const std::string& path);

[[nodiscard]] std::unique_ptr<Camera> make_video_camera(std::shared_ptr<VideoKernel> kernel);

}  // namespace rigcal::camera
