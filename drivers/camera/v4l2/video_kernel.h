#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace rigcal::camera {

/// The system's calls that cameras of Video4Linux are used by, so that a test can answer them. From any thread.
class VideoKernel {
 public:
  virtual ~VideoKernel() = default;

  /// Device files that may be cameras.
  [[nodiscard]] virtual std::vector<std::string> devices() = 0;
  /// The serial number of the USB device behind a device file; empty where there is none.
  [[nodiscard]] virtual std::string serial(const std::string& path) = 0;
  /// What a parameter of a driver is set to; empty where it has no such thing.
  [[nodiscard]] virtual std::string parameter(const std::string& driver, const std::string& name) = 0;
  /// A descriptor, or an errno below zero.
  [[nodiscard]] virtual int open(const std::string& path) = 0;
  virtual void close(int descriptor) = 0;
  /// 0, or an errno below zero. What was interrupted is done again.
  virtual int control(int descriptor, unsigned long request, void* argument) = 0;
  /// Nothing where it cannot be done.
  [[nodiscard]] virtual void* map(int descriptor, std::size_t bytes, std::int64_t offset) = 0;
  virtual void unmap(void* memory, std::size_t bytes) = 0;

  struct Ready {
    bool frame = false;  ///< A buffer can be taken.
    bool event = false;
    bool error = false;  ///< No buffer is queued, or the stream broke off.
    bool gone = false;   ///< The device was taken away.
  };
  /// Waits for any of these, at most that long.
  [[nodiscard]] virtual Ready wait(int descriptor, std::int64_t timeout_ns) = 0;
};

/// The one of this machine.
[[nodiscard]] std::shared_ptr<VideoKernel> system_video_kernel();

}  // namespace rigcal::camera
