#include "core/corner/ransac_planes.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "simdata/targets/corner_clouds.h"

namespace rigcal {
namespace {

TEST(FitPlane, GivesTheLeastSquaresPlaneWithItsNormalTowardsTheSensor) {
  PointCluster points;
  Random random(1);
  for (int k = 0; k < 2000; ++k) {
    points.add({random.uniform(-1.0, 2.0), random.uniform(0.0, 4.0), 2.0 + 0.01 * random.normal()});
  }
  const auto plane = fit_plane(points);
  ASSERT_TRUE(plane);
  EXPECT_LT((plane->normal + Vector3d::UnitZ()).norm(), 1e-3);
  EXPECT_NEAR(plane->offset_m, -2.0, 1e-3);
  EXPECT_NEAR(plane->sigma_m, 0.01, 1e-3);
  EXPECT_NEAR(plane->flipped().distance({0.0, 0.0, 2.5}), 0.5, 2e-3);
}

TEST(FitPlane, SaysNothingOfTwoPointsOrALine) {
  PointCluster points;
  points.add({0.0, 0.0, 1.0});
  points.add({1.0, 0.0, 1.0});
  EXPECT_FALSE(fit_plane(points));
  points.add({2.0, 0.0, 1.0});
  EXPECT_FALSE(fit_plane(points));
}

TEST(PlaneMoments, AreTheScatterWithoutTheShareOfTheNoise) {
  PointCluster points;
  Random random(2);
  for (int k = 0; k < 500; ++k) points.add({random.normal(), 2.0 * random.normal(), 5.0 + 0.1 * random.normal()});
  const PlaneMoments moments = moments_of(points);
  EXPECT_EQ(moments.scatter[0], 0.0);
  EXPECT_NEAR(moments.scatter[1] / moments.N, 1.0, 0.2);
  EXPECT_NEAR((moments.scatter_matrix() * moments.axes.col(0)).norm(), 0.0, 1e-9);
}

class RansacPlanes : public ::testing::Test {
 protected:
  const sim::CornerCloud cloud_ = sim::make_corner_clouds({.angle_deg = 70.0}).a;
};

TEST_F(RansacPlanes, FindTheThreePlanesOfACornerAmongStrayPoints) {
  const auto planes = ransac_planes(cloud_.points, RansacOptions{});
  ASSERT_EQ(planes.size(), 3U);
  const Vector3d left(-std::sin(to_rad(35.0)), -std::cos(to_rad(35.0)), 0.0);
  for (const Vector3d& truth : {left, Vector3d(left.x(), -left.y(), 0.0), Vector3d(0.0, 0.0, 1.0)}) {
    double best = -1.0;
    for (const FittedPlane& plane : planes) best = std::max(best, plane.normal.dot(truth));
    EXPECT_GT(best, std::cos(to_rad(0.3)));
  }
  for (const FittedPlane& plane : planes) EXPECT_NEAR(plane.sigma_m, 0.1, 0.02);
}

TEST_F(RansacPlanes, AreTheSameForTheSameSeed) {
  RansacOptions options;
  options.seed = 7;
  const auto once = ransac_planes(cloud_.points, options);
  const auto again = ransac_planes(cloud_.points, options);
  ASSERT_EQ(once.size(), again.size());
  for (std::size_t k = 0; k < once.size(); ++k) {
    EXPECT_EQ(once[k].normal, again[k].normal);
    EXPECT_EQ(once[k].offset_m, again[k].offset_m);
  }
}

TEST_F(RansacPlanes, AreFewerWhereThereAreFewer) {
  std::vector<Vector3d> two_walls;
  for (std::size_t k = 0; k < cloud_.points.size(); ++k) {
    if (cloud_.plane[k] == 0 || cloud_.plane[k] == 1) two_walls.push_back(cloud_.points[k]);
  }
  EXPECT_EQ(ransac_planes(two_walls, RansacOptions{}).size(), 2U);
  EXPECT_TRUE(ransac_planes({}, RansacOptions{}).empty());
  const std::vector<Vector3d> same(100, Vector3d(1.0, 2.0, 3.0));
  EXPECT_TRUE(ransac_planes(same, RansacOptions{}).empty());
}

}  // namespace
}  // namespace rigcal
