#pragma once

#include <cmath>
#include <cstddef>

#include "core/geometry/se3.h"

namespace rigcal {

/// The i-th of `count` unit vectors that lie evenly over the sphere, on a spiral whose turns are golden sections.
[[nodiscard]] inline Vector3d spiral_direction(std::size_t i, std::size_t count) {
  const double golden = pi * (3.0 - std::sqrt(5.0));
  const double z = 1.0 - (2.0 * static_cast<double>(i) + 1.0) / static_cast<double>(count);
  const double r = std::sqrt(1.0 - z * z);
  const double phi = golden * static_cast<double>(i);
  return {r * std::cos(phi), r * std::sin(phi), z};
}

}  // namespace rigcal
