#pragma once

#include <cstdint>
#include <vector>

namespace rigcal::sim {

/// The mean of some of the values of a frame as it goes over the wire, 1: the largest value. `pixel_format` is the
/// number of a format that is not packed.
[[nodiscard]] double mean_brightness(const std::vector<std::uint8_t>& image, std::uint32_t pixel_format);

}  // namespace rigcal::sim
