#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

#include "core/base/error.h"
#include "drivers/camera/frame.h"
#include "drivers/camera/v4l2/video_device.h"

namespace rigcal::camera {

/// Buffers of the kernel, mapped into this program: queued there, waiting there filled, or lent.
class VideoBuffers final : public FrameStore {
 public:
  /// Errors: the kernel gives none (another program streams), too few, or no memory.
  [[nodiscard]] static Expected<std::shared_ptr<VideoBuffers>> make(std::shared_ptr<const VideoDevice> device,
                                                                    std::size_t count, std::string pixel_format);
  ~VideoBuffers() override;
  VideoBuffers(const VideoBuffers&) = delete;
  VideoBuffers& operator=(const VideoBuffers&) = delete;

  /// Queues all that are not lent, and lets the stream begin.
  Expected<void> start();
  /// The stream ends. How many filled buffers nobody took.
  std::uint64_t stop();

  struct Filled {
    std::size_t buffer = 0;
    std::size_t bytes = 0;  ///< That the frame has.
    std::uint32_t sequence = 0;
    std::int64_t stamp_ns = 0;  ///< CLOCK_MONOTONIC; 0: of another clock.
    bool is_damaged = false;
  };
  /// Takes a filled buffer; it is lent from then on. 0, or an errno below zero.
  int take(Filled& filled);
  void give_back(std::size_t buffer) noexcept override;

  /// To be called once the kernel has its buffers back, which the last lent one may keep it from: until then it takes
  /// no other format. By the thread that gives that one back; for the owner, before it lets go of this.
  void set_at_end(std::function<void()> at_end) { at_end_ = std::move(at_end); }

  [[nodiscard]] ByteView bytes(std::size_t buffer, std::size_t size) const;
  /// Whether all are lent, so that the kernel has none to fill.
  [[nodiscard]] bool is_dry() const;
  /// Whether stamps are of the start of a frame's exposure, as the kernel says.
  [[nodiscard]] bool stamps_exposure() const { return stamps_exposure_; }
  [[nodiscard]] std::size_t smallest() const;
  [[nodiscard]] const std::string& pixel_format() const { return pixel_format_; }

 private:
  struct Place {
    std::uint8_t* memory = nullptr;
    std::size_t bytes = 0;
    bool is_lent = false;
  };
  VideoBuffers(std::shared_ptr<const VideoDevice> device, std::string pixel_format)
      : device_(std::move(device)), pixel_format_(std::move(pixel_format)) {}
  int queue(std::size_t buffer) const;

  std::shared_ptr<const VideoDevice> device_;
  std::string pixel_format_;
  bool stamps_exposure_ = false;
  std::function<void()> at_end_;
  mutable std::mutex mutex_;  ///< Of what follows.
  std::vector<Place> places_;
  std::size_t lent_ = 0;
  bool is_running_ = false;
};

}  // namespace rigcal::camera
