#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/camera/frame.h"

namespace rigcal::camera {

/// Buffers of one size in this program's memory, asked for once.
class FramePool final : public FrameStore {
 public:
  FramePool(std::size_t buffers, std::size_t bytes, std::string pixel_format)
      : pixel_format_(std::move(pixel_format)), bytes_(bytes), memory_(buffers * bytes) {
    free_.reserve(buffers);
    for (std::size_t i = buffers; i > 0; --i) free_.push_back(i - 1);
  }

  /// A buffer that nobody has, or nothing.
  [[nodiscard]] std::optional<std::size_t> take() {
    const std::lock_guard lock(mutex_);
    if (free_.empty()) return std::nullopt;
    const std::size_t buffer = free_.back();
    free_.pop_back();
    return buffer;
  }
  void give_back(std::size_t buffer) noexcept override {
    const std::lock_guard lock(mutex_);
    free_.push_back(buffer);
  }
  [[nodiscard]] const std::string& pixel_format() const { return pixel_format_; }
  [[nodiscard]] std::span<std::uint8_t> bytes(std::size_t buffer) {
    return std::span(memory_).subspan(buffer * bytes_, bytes_);
  }

 private:
  std::string pixel_format_;
  std::size_t bytes_;
  std::vector<std::uint8_t> memory_;
  std::mutex mutex_;
  std::vector<std::size_t> free_;  ///< With room for all.
};

}  // namespace rigcal::camera
