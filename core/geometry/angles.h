#pragma once

#include <cmath>

#include "core/geometry/se3.h"

namespace rigcal {

/// How far two directions about one axis are apart, rad, 0 .. pi; whole turns do not count.
[[nodiscard]] inline double angle_apart(double a_rad, double b_rad) {
  return std::abs(std::remainder(a_rad - b_rad, 2.0 * pi));
}

}  // namespace rigcal
