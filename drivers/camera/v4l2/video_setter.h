#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/camera/camera_config.h"
#include "drivers/camera/v4l2/video_device.h"

namespace rigcal::camera {

/// Sets a device up, and knows what it has changed.
class VideoSetter {
 public:
  explicit VideoSetter(std::shared_ptr<const VideoDevice> device) : device_(std::move(device)) {}

  /// After `restore`, so that what is not asked for is as it was found. Errors: what the device cannot do, with what
  /// it can.
  [[nodiscard]] Expected<CameraSetup> apply(const CameraConfig& config);
  /// Puts back what it was before, the last change first.
  void restore();

  [[nodiscard]] std::size_t row_bytes() const { return row_bytes_; }

 private:
  Expected<void> set_format(const CameraConfig& config);
  Expected<void> set_crop(const Region& region);
  Expected<void> set_rate(double frame_rate);
  Expected<void> set_exposure(double exposure_us);
  Expected<void> set_gain(double gain);
  /// A control within its limits; `unit` of one step, for the message.
  Expected<void> set_within(std::uint32_t id, double value, double step_unit, const std::string& what);
  Expected<void> set_control(std::uint32_t id, std::int32_t value, const std::string& what);
  [[nodiscard]] std::optional<std::int32_t> control(std::uint32_t id) const;
  [[nodiscard]] std::string sizes_text(std::uint32_t fourcc) const;
  [[nodiscard]] Error refused(std::string what, std::string mend) const;

  std::shared_ptr<const VideoDevice> device_;
  std::vector<std::function<void()>> undo_;
  CameraSetup setup_;
  std::size_t row_bytes_ = 0;
};

}  // namespace rigcal::camera
