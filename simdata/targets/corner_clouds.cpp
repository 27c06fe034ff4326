#include "simdata/targets/corner_clouds.h"

#include <cmath>

#include "simdata/scene/random_vectors.h"

namespace rigcal::sim {
namespace {

// In the frame of LiDAR a, which stands in the middle and looks into the corner.
CornerCloud draw(const CornerCloudOptions& options, Random& random) {
  const double half = 0.5 * to_rad(options.angle_deg);
  const Vector3d along_left(-std::cos(half), std::sin(half), 0.0);
  const Vector3d along_right(-std::cos(half), -std::sin(half), 0.0);
  const Vector3d up = Vector3d::UnitZ();
  const Vector3d sides[3][2] = {{along_left, up}, {along_right, up}, {along_left, along_right}};
  const Vector3d corner = -0.5 * options.size_m * (along_left + along_right + up);
  CornerCloud cloud;
  for (int k = 0; k < options.points; ++k) {
    const int plane = 3 * k / options.points;
    const double s = random.uniform(0.0, options.size_m);
    const double t = random.uniform(0.0, options.size_m);
    cloud.points.emplace_back(corner + s * sides[plane][0] + t * sides[plane][1] +
                              options.sigma_m * random_normal3(random));
    cloud.plane.push_back(plane);
  }
  for (int k = 0; k < options.stray_points; ++k) {
    cloud.points.emplace_back(options.stray_sigma_m * random_normal3(random));
    cloud.plane.push_back(-1);
  }
  return cloud;
}

}  // namespace

CornerClouds make_corner_clouds(const CornerCloudOptions& options) {
  Random random_a(options.seed, 0);
  Random random_b(options.seed, options.shared_noise ? 0 : 1);
  CornerClouds clouds{draw(options, random_a), draw(options, random_b)};
  const SE3 T_b_a = options.T_a_b.inverse();
  for (Vector3d& p : clouds.b.points) p = T_b_a * p;
  return clouds;
}

SE3 paper_configuration(int number) {
  const auto from = [](double a, double b, double c, const Vector3d& t) {
    return SE3{exp_so3(a * Vector3d::UnitZ()) * exp_so3(b * Vector3d::UnitY()) * exp_so3(c * Vector3d::UnitX()), t};
  };
  return number == 1 ? from(2.7337, -0.3946, -0.1809, {0.8766, 0.4672, 1.0474})
                     : from(-0.5174, 0.1277, 0.1222, {1.3785, -1.3929, 1.3020});
}

}  // namespace rigcal::sim
