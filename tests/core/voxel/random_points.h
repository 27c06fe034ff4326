#pragma once

#include <cstdint>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/se3.h"
#include "core/records/records.h"

namespace rigcal {

inline Point point(double x, double y, double z) {
  Point p;
  p.x = static_cast<float>(x);
  p.y = static_cast<float>(y);
  p.z = static_cast<float>(z);
  return p;
}

inline Vector3d vector_of(const Point& p) { return {p.x, p.y, p.z}; }

/// In a cube from -reach to reach.
inline std::vector<Point> random_points(std::size_t count, double reach, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(-reach, reach);
    const double y = random.uniform(-reach, reach);
    const double z = random.uniform(-reach, reach);
    points.push_back(point(x, y, z));
  }
  return points;
}

}  // namespace rigcal
