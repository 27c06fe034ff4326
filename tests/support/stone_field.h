#pragma once

#include <vector>

#include "core/base/random.h"
#include "core/geometry/se3.h"

namespace rigcal {

/// A floor with the same stones on it each time, as a LiDAR that stands at `T` sees it: one plane and shapes.
inline std::vector<Vector3d> see_stone_field(const SE3& T, Random& random) {
  Random of_stones(77);
  std::vector<Vector3d> points;
  for (int k = 0; k < 6000; ++k) {
    points.emplace_back(random.uniform(-5.0, 5.0), random.uniform(-5.0, 5.0), -1.5 + 0.01 * random.normal());
  }
  for (int stone = 0; stone < 60; ++stone) {
    const Vector3d middle(of_stones.uniform(-5.0, 5.0), of_stones.uniform(-5.0, 5.0), of_stones.uniform(-1.2, 0.8));
    for (int k = 0; k < 200; ++k) {
      const Vector3d direction(random.normal(), random.normal(), random.normal());
      points.push_back(middle + 0.3 * direction.normalized());
    }
  }
  for (Vector3d& p : points) p = T.inverse() * p;
  return points;
}

}  // namespace rigcal
