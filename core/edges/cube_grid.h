#pragma once

#include <cmath>
#include <cstdint>

#include "core/base/packed_cube.h"
#include "core/geometry/se3.h"

namespace rigcal {

/// The place of a cube of a grid, in cubes from the origin.
struct CubePlace {
  std::int64_t x = 0;
  std::int64_t y = 0;
  std::int64_t z = 0;
};

/// One number for a place up to 2^20 cubes from the origin; in the order of x, then y, then z.
[[nodiscard]] inline std::uint64_t cube_number(const CubePlace& at) { return packed_cube(at.x, at.y, at.z); }

/// The cube of edge 1 / `per_m` that holds p.
[[nodiscard]] inline CubePlace cube_place(const Vector3d& p, double per_m) {
  const auto part = [per_m](double x) { return static_cast<std::int64_t>(std::floor(x * per_m)); };
  return {part(p.x()), part(p.y()), part(p.z())};
}

}  // namespace rigcal
