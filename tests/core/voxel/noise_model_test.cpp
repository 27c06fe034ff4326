#include "core/voxel/noise_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

Vector3d random_vector(Random& random, double scale) {
  const double x = scale * random.normal();
  const double y = scale * random.normal();
  const double z = scale * random.normal();
  return {x, y, z};
}

TEST(NoiseModel, VarianceAlongADirectionIsThatOfTheCovariance) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const NoiseModel noise{random.uniform(0.0, 0.05), random.uniform(0.0, 0.01), random.uniform(0.0, 0.01),
                           random.uniform(0.0, 1.0)};
    const Vector3d p = random_vector(random, 20.0);
    const Vector3d u = random_vector(random, 1.0).normalized();
    const double expected = u.dot(noise.point_covariance(p, u) * u);
    EXPECT_NEAR(expected, noise.variance_along(p, u), 1e-12 * (1e-3 + expected));
  }
}

TEST(NoiseModel, HasTheRangeNoiseAlongTheRayAndTheAngleNoiseAcross) {
  const NoiseModel noise{0.02, 0.001, 0.0005};
  const Vector3d p(30.0, 0.0, 40.0);
  const Vector3d ray(0.6, 0.0, 0.8);
  // 50 m away: 0.02^2 + 0.05^2 along the ray, (50 x 0.0005)^2 across it.
  EXPECT_NEAR(0.0004 + 0.0025, noise.variance_along(p, ray), 1e-15);
  EXPECT_NEAR(0.025 * 0.025, noise.variance_along(p, Vector3d::UnitY()), 1e-15);
  EXPECT_NEAR(0.025 * 0.025, noise.variance_along(p, Vector3d(0.8, 0.0, -0.6)), 1e-15);
  EXPECT_NEAR(0.0, ray.dot(noise.point_covariance(p, ray) * Vector3d::UnitY()), 1e-15);
}

TEST(NoiseModel, GrowsWhereASurfaceIsMetAtASlant) {
  const NoiseModel noise{0.02, 0.001, 0.0, 0.4};
  const Vector3d p(10.0, 0.0, 0.0);
  const double straight = 0.0004 + 0.0001;
  EXPECT_NEAR(straight, noise.variance_along(p, Vector3d::UnitX()), 1e-15);
  EXPECT_NEAR(straight, noise.variance_along(p, -Vector3d::UnitX()), 1e-15);
  // At 60 degrees its sigma is 1.2 times as large, and half of it stands across the surface.
  const Vector3d n(0.5, std::sqrt(0.75), 0.0);
  EXPECT_NEAR(1.44 * straight, noise.range_variance(100.0, 0.5), 1e-15);
  EXPECT_NEAR(0.25 * 1.44 * straight, noise.variance_along(p, n), 1e-15);
  EXPECT_NEAR(1.44 * straight, noise.point_covariance(p, n)(0, 0), 1e-15);
}

TEST(NoiseModel, IsTheCovarianceOfPointsDrawnFromIt) {
  Random random(2);
  const NoiseModel noise{0.02, 0.002, 0.003};
  const Vector3d p(6.0, -3.0, 2.0);
  constexpr int draws = 40000;
  Matrix3d sum = Matrix3d::Zero();
  for (int i = 0; i < draws; ++i) {
    const Point m = measured(p, noise, random);
    const Vector3d d = Vector3d(m.x, m.y, m.z) - p;
    sum += d * d.transpose() / draws;
  }
  const Matrix3d S = noise.point_covariance(p, p.normalized());
  // An element of a covariance of n draws scatters by sqrt((S_ii S_jj + S_ij^2) / n).
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(S(i, j), sum(i, j), 4.5 * std::sqrt((S(i, i) * S(j, j) + S(i, j) * S(i, j)) / draws));
  }
}

}  // namespace
}  // namespace rigcal
