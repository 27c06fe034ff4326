#include "core/corner/seen_planes.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/corner/plane_shares.h"
#include "simdata/targets/corner_clouds.h"

namespace rigcal {
namespace {

TEST(SeenPlanes, AreThoseOfTheCornerWhateverTheNoise) {
  for (const double sigma_m : {0.01, 0.03, 0.1}) {
    const auto clouds = sim::make_corner_clouds({.angle_deg = 80.0, .sigma_m = sigma_m});
    const auto planes = find_planes(plane_cloud(clouds.a.points));
    ASSERT_EQ(planes.size(), 3U) << sigma_m;
    for (const SeenPlane& seen : planes) {
      EXPECT_NEAR(seen.plane.sigma_m, sigma_m, 0.1 * sigma_m);
      EXPECT_NEAR(seen.plane.points.N, 2500.0, 150.0);
      EXPECT_NEAR(seen.area_m2, 100.0, 35.0);
      EXPECT_LT(seen.plane.distance(Vector3d::Zero()), 6.0);
      EXPECT_GT(seen.plane.distance(Vector3d::Zero()), 3.0) << "the normal is towards the sensor";
      EXPECT_EQ(seen.unevenness_m, 0.0);
    }
  }
}

TEST(SeenPlanes, AreNoneAmongStrayPoints) {
  const auto clouds = sim::make_corner_clouds({.points = 0, .stray_points = 4000});
  EXPECT_TRUE(find_planes(plane_cloud(clouds.a.points)).empty());
  EXPECT_TRUE(find_planes(PlaneCloud{}).empty());
}

TEST(SeenPlanes, TellHowUnevenASurfaceIs) {
  Random random(4);
  std::vector<Vector3d> road;
  for (int k = 0; k < 20000; ++k) {
    const double x = random.uniform(-10.0, 10.0);
    const double y = random.uniform(-6.0, 6.0);
    road.emplace_back(x, y, -2.0 - 0.002 * y * y + 0.01 * random.normal());  // crowned by 7 cm
  }
  const auto planes = find_planes(plane_cloud(road));
  ASSERT_EQ(planes.size(), 1U);
  EXPECT_GT(planes[0].unevenness_m, 0.01);
  EXPECT_LT(planes[0].weight(), 0.2 / (0.01 * 0.01));
}

TEST(PlaneArea, HoldsThePartsThatWereSeenAndNoOthers) {
  Random random(5);
  std::vector<Vector3d> points;
  PointCluster cluster;
  for (int k = 0; k < 3000; ++k) {
    points.emplace_back(random.uniform(0.0, 8.0), random.uniform(0.0, 3.0), 1.0 + 0.02 * random.normal());
    cluster.add(points.back());
  }
  FittedPlane plane = *fit_plane(cluster);
  const PlaneArea area(plane, points, 0.5);
  EXPECT_NEAR(area.area_m2(), 24.0, 6.0);
  EXPECT_GE(area.part_of({4.0, 1.5, 1.0}), 0);
  EXPECT_LT(area.part_of({4.0, 5.0, 1.0}), 0);
  EXPECT_LT(area.part_of({1e6, -1e9, 1.0}), 0);

  std::vector<Vector3d> half;
  for (const Vector3d& p : points) {
    if (p.x() < 4.0) half.push_back(p);
  }
  const PlaneArea common = PlaneArea::common({area, PlaneArea(plane, half, 0.5)});
  EXPECT_NEAR(common.area_m2(), 12.0, 4.0);
  EXPECT_GE(common.part_of({2.0, 1.5, 1.0}), 0);
  EXPECT_LT(common.part_of({6.0, 1.5, 1.0}), 0);
}

}  // namespace
}  // namespace rigcal
