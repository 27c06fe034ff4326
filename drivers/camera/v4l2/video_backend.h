#pragma once

#include <memory>
#include <string_view>
#include <utility>
#include <vector>

#include "drivers/camera/camera.h"
#include "drivers/camera/v4l2/video_kernel.h"

namespace rigcal::camera {

/// Cameras of Video4Linux with buffers that the kernel fills (single-planar, mapped): grey and Bayer of 8 to 16 bits,
/// RGB of 8. They run free, at the rate that is set; the size of an image is set as the driver does it, which may be a
/// part of the sensor or its whole made smaller. A camera may also be opened by any path of its device file.
///
/// Host stamps are the kernel's: of a frame's end, which a driver may foretell by up to a period, of its first packet,
/// or of the start of its exposure, see CameraSetup::host_stamp; there are no stamps of the camera's own. A camera that
/// is unplugged is noticed at once, a stream that breaks off or changes, too: both are `lost`, and looked for.
class VideoBackend final : public CameraBackend {
 public:
  explicit VideoBackend(std::shared_ptr<VideoKernel> kernel = system_video_kernel()) : kernel_(std::move(kernel)) {}
  [[nodiscard]] std::string_view name() const override { return "v4l2"; }
  [[nodiscard]] Expected<std::vector<CameraIdentity>> enumerate() override;
  [[nodiscard]] std::unique_ptr<Camera> make() override;

 private:
  std::shared_ptr<VideoKernel> kernel_;
};

}  // namespace rigcal::camera
