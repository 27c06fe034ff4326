#pragma once

#include <cstdint>
#include <vector>

#include "simdata/gige/virtual_camera.h"

namespace rigcal::sim::usb3 {

inline constexpr std::size_t kLeaderBytes = 52;
inline constexpr std::size_t kTrailerBytes = 32;

/// What goes before and after the pixels of a frame on the stream. Stamps are nanoseconds of the camera's clock.
[[nodiscard]] std::vector<std::uint8_t> encode_leader(const FrameOrder& frame, std::uint64_t stamp_ns);
[[nodiscard]] std::vector<std::uint8_t> encode_trailer(const FrameOrder& frame);

}  // namespace rigcal::sim::usb3
