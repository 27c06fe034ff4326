#pragma once

#include <memory>
#include <string>
#include <utility>

#include "drivers/camera/v4l2/video_kernel.h"

namespace rigcal::camera {

/// An open device file, closed when the last of its users ends.
class VideoDevice {
 public:
  VideoDevice(std::shared_ptr<VideoKernel> kernel, int descriptor, std::string path)
      : kernel_(std::move(kernel)), descriptor_(descriptor), path_(std::move(path)) {}
  ~VideoDevice() { kernel_->close(descriptor_); }
  VideoDevice(const VideoDevice&) = delete;
  VideoDevice& operator=(const VideoDevice&) = delete;

  /// 0, or an errno below zero.
  int control(unsigned long request, void* argument) const { return kernel_->control(descriptor_, request, argument); }
  [[nodiscard]] VideoKernel::Ready wait(std::int64_t timeout_ns) const {
    return kernel_->wait(descriptor_, timeout_ns);
  }
  [[nodiscard]] void* map(std::size_t bytes, std::int64_t offset) const {
    return kernel_->map(descriptor_, bytes, offset);
  }
  void unmap(void* memory, std::size_t bytes) const { kernel_->unmap(memory, bytes); }
  [[nodiscard]] const std::string& path() const { return path_; }

 private:
  std::shared_ptr<VideoKernel> kernel_;
  int descriptor_;
  std::string path_;
};

}  // namespace rigcal::camera
