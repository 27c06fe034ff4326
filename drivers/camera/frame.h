#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string_view>
#include <utility>

#include "core/base/bytes.h"

namespace rigcal::camera {

/// What came of a frame. Only a whole one has pixels.
enum class FrameStatus : std::uint8_t {
  whole,
  incomplete,    ///< Parts of it got lost on the way, and were not there again in time.
  wrong_size,    ///< Not of the size that was set up.
  device_error,  ///< The camera, or the system, says that it is damaged.
  out_of_order,  ///< Packets or parts that belong elsewhere.
};
constexpr std::size_t kFrameStatuses = 5;
[[nodiscard]] const char* to_string(FrameStatus status);

/// What is known of a frame. Stamps that the camera does not give are missing.
struct FrameFacts {
  FrameStatus status = FrameStatus::whole;
  /// As the camera counts them; what it jumps is in `missing_before`. Wraps as the camera's counter does.
  std::uint64_t frame_id = 0;
  std::uint64_t missing_before = 0;             ///< Frames since the last one that never came, by their ids.
  std::int64_t host_stamp_ns = 0;               ///< CLOCK_MONOTONIC, of the moment that CameraSetup::host_stamp says.
  std::optional<std::int64_t> device_stamp_ns;  ///< On the camera's own clock, or a file's stamp.
  std::optional<double> exposure_us;            ///< As the frame itself says it.
  int width = 0;
  int height = 0;
  std::size_t row_bytes = 0;
  std::string_view pixel_format;  ///< As CameraSetup::pixel_format; lives as long as the frame.
};

/// Keeps the memory of frames; lives as long as any frame of it. Called from any thread.
class FrameStore {
 public:
  virtual ~FrameStore() = default;
  /// The buffer may be filled again.
  virtual void give_back(std::size_t buffer) noexcept = 0;
};

/// A frame that is lent: its buffer goes back to the camera when this ends, in any thread, also after the camera has
/// been stopped, closed or destroyed. While all buffers are lent the camera's frames are lost, and counted.
class Frame {
 public:
  Frame() = default;
  Frame(FrameFacts facts, ByteView pixels, std::shared_ptr<FrameStore> store, std::size_t buffer)
      : facts_(facts), pixels_(pixels), store_(std::move(store)), buffer_(buffer) {}
  Frame(Frame&& other) noexcept { swap(other); }
  Frame& operator=(Frame&& other) noexcept {
    Frame old(std::move(*this));
    swap(other);
    return *this;
  }
  Frame(const Frame&) = delete;
  Frame& operator=(const Frame&) = delete;
  ~Frame() { give_back(); }

  [[nodiscard]] const FrameFacts& facts() const { return facts_; }
  [[nodiscard]] bool is_whole() const { return store_ && facts_.status == FrameStatus::whole; }
  /// `height` rows of `row_bytes`; empty where the frame is not whole. 16 bit values have their low byte first.
  [[nodiscard]] ByteView pixels() const { return pixels_; }
  /// Gives the buffer back before the end.
  void give_back() {
    pixels_ = {};
    if (store_) store_->give_back(buffer_);
    store_.reset();
  }

 private:
  void swap(Frame& other) noexcept {
    std::swap(facts_, other.facts_);
    std::swap(pixels_, other.pixels_);
    std::swap(store_, other.store_);
    std::swap(buffer_, other.buffer_);
  }

  FrameFacts facts_;
  ByteView pixels_;
  std::shared_ptr<FrameStore> store_;
  std::size_t buffer_ = 0;
};

}  // namespace rigcal::camera
