#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

namespace rigcal {

/// Eight colours that are told apart whatever the colour vision, and stand out on white and on black: those of Okabe
/// and Ito (2008) with the darkest and the brightest ones moved to the middle. Sensors in the order of the rig file,
/// and series of plots; by custom the first is the result and the second the guess.
constexpr std::array<std::array<std::uint8_t, 3>, 8> series_rgb{{{64, 156, 224},
                                                                 {230, 146, 0},
                                                                 {0, 168, 126},
                                                                 {205, 115, 168},
                                                                 {213, 94, 0},
                                                                 {158, 148, 20},
                                                                 {120, 138, 160},
                                                                 {140, 107, 209}}};

[[nodiscard]] constexpr const std::array<std::uint8_t, 3>& series_colour(std::size_t series) {
  return series_rgb[series % series_rgb.size()];
}

}  // namespace rigcal
