#pragma once

#include <cmath>
#include <vector>

#include "core/base/random.h"
#include "core/geometry/se3.h"
#include "core/records/records.h"

namespace rigcal {

/// What sixteen rings see from the middle of a round room of 6 m: the nearest of rectangular plates of one size (pose
/// in the LiDAR's frame), else the wall. The points carry their ring.
inline std::vector<Point> ring_scan(const std::vector<SE3>& plates, const Eigen::Vector2d& size, double sigma_m,
                                    Random& random) {
  constexpr double wall_m = 6.0;
  std::vector<Point> out;
  for (int ring = 0; ring < 16; ++ring) {
    const double elevation = to_rad(-15.0 + 2.0 * ring);
    for (int k = 0; k < 1800; ++k) {
      const double azimuth = to_rad(0.2 * k);
      const Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
      double range = wall_m / std::cos(elevation);
      for (const SE3& T : plates) {
        const double along = T.R.col(2).dot(ray);
        if (std::abs(along) < 1e-3) continue;
        const double r = T.R.col(2).dot(T.t) / along;
        const Vector3d q = T.inverse() * (r * ray);
        if (r > 0.0 && r < range && std::abs(q.x()) < 0.5 * size.x() && std::abs(q.y()) < 0.5 * size.y()) range = r;
      }
      const Vector3d p = (range + sigma_m * random.normal()) * ray;
      Point point;
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
      point.shot = static_cast<std::uint16_t>(ring);
      out.push_back(point);
    }
  }
  return out;
}

/// A plate that looks at the origin from a direction and a distance, turned about its normal, leaning.
inline SE3 plate_at(double azimuth, double range, double turn, double lean) {
  SE3 T;
  // z away from the sensor, y down.
  T.R << 0.0, 0.0, 1.0, -1.0, 0.0, 0.0, 0.0, -1.0, 0.0;
  T.R = exp_so3({0.0, 0.0, azimuth}) * T.R * exp_so3({lean, 0.5 * lean, 0.0}) * exp_so3({0.0, 0.0, turn});
  T.t = range * Vector3d(std::cos(azimuth), std::sin(azimuth), 0.0);
  return T;
}

}  // namespace rigcal
