#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace rigcal::sim {

/// A frame that a virtual camera has to send, as it was set when it exposed.
struct FrameWish {
  std::uint64_t number = 0;           ///< Since the acquisition began.
  std::int64_t start_ns = 0;          ///< Of the exposure, CLOCK_MONOTONIC.
  std::optional<std::int64_t> pulse;  ///< Number of the trigger's pulse.
  std::string pixel_format;
  int width = 0;  ///< Part of the sensor, and where it lies.
  int height = 0;
  int offset_x = 0;
  int offset_y = 0;
  double exposure_us = 0.0;
  double gain_db = 0.0;
};

/// Where a virtual camera's pixels come from. Called in the server's thread: what takes long belongs into another one.
class FrameSource {
 public:
  virtual ~FrameSource() = default;
  /// Puts the pixels into `out` (rows without gaps, 16 bit values low byte first), which may hold those of a frame
  /// before. False: not yet, ask again.
  virtual bool make(const FrameWish& wish, std::vector<std::uint8_t>& out) = 0;
};

}  // namespace rigcal::sim
