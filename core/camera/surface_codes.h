#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/camera/camera_scene.h"

namespace rigcal {

/// Ranks of reflectivity, each with as many samples as the others where the values allow it.
constexpr int reflectivity_ranks = 16;
/// On no plane, upwards, downwards, and eight azimuths: light falls on each in another way, so shading tells of them.
constexpr int facings = 11;
constexpr int surface_codes_count = reflectivity_ranks * facings;

/// What the LiDARs know of a surface that a camera may see as well.
struct SurfaceCodes {
  std::vector<std::uint8_t> of_sample;  ///< facing * reflectivity_ranks + rank
};

/// Ranks are taken within each LiDAR, as units differ in what they call bright.
[[nodiscard]] SurfaceCodes surface_codes(std::span<const MapSample> samples);

}  // namespace rigcal
