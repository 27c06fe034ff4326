#include "simdata/targets/corner_scans.h"

#include <cmath>

#include "core/base/random.h"

namespace rigcal::sim {
namespace {

CornerCloud scan(const CornerScanOptions& options, const SE3& T, const ScanField& field, double too_long_m,
                 Random& random) {
  CornerCloud cloud;
  const double angle = pi - to_rad(options.angle_deg);
  Matrix3d outwards;
  outwards << 1.0, 0.0, 0.0, std::cos(angle), std::sin(angle), 0.0, 0.0, 0.0, -1.0;
  const Vector3d ahead_m = options.walls_m - outwards * T.t;
  for (int k = 0; k < options.rays; ++k) {
    const double side = random.uniform(-field.half_width_rad, field.half_width_rad);
    const double up = random.uniform(-field.half_height_rad, field.half_height_rad) + options.tilt_rad;
    const Vector3d ray(std::cos(up) * std::cos(side), std::cos(up) * std::sin(side), std::sin(up));
    const Vector3d towards = outwards * (T.R * ray);
    double range_m = options.max_range_m;
    int plane = -1;
    for (int wall = 0; wall < 3; ++wall) {
      if (towards[wall] < 1e-3 || ahead_m[wall] / towards[wall] > range_m) continue;
      range_m = ahead_m[wall] / towards[wall];
      plane = wall;
    }
    if (plane < 0) continue;
    cloud.points.emplace_back((range_m + too_long_m + options.sigma_m * random.normal()) * ray);
    cloud.plane.push_back(plane);
  }
  return cloud;
}

}  // namespace

CornerClouds make_corner_scans(const CornerScanOptions& options) {
  Random random_a(options.seed, 0);
  Random random_b(options.seed, 1);
  return {scan(options, SE3{}, options.field_a, 0.0, random_a),
          scan(options, options.T_a_b, options.field_b, options.b_too_long_m, random_b)};
}

}  // namespace rigcal::sim
