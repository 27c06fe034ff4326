#include "core/corner/paper_method.h"

#include <gtest/gtest.h>

#include "simdata/targets/corner_clouds.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

sim::CornerClouds clouds_of(int configuration, double angle_deg, bool shared, std::uint64_t seed) {
  return sim::make_corner_clouds(
      {.angle_deg = angle_deg, .T_a_b = sim::paper_configuration(configuration), .shared_noise = shared, .seed = seed});
}

TEST(PaperMethod, IsExactWhereBothCloudsShareTheirNoise) {
  for (const int configuration : {1, 2}) {
    for (const double angle_deg : {60.0, 90.0, 120.0}) {
      const auto clouds = clouds_of(configuration, angle_deg, true, 1);
      const auto found = calibrate_as_published(clouds.a.points, clouds.b.points);
      ASSERT_TRUE(found) << found.error().what;
      EXPECT_THAT(found->T_a_b, SE3Near(sim::paper_configuration(configuration), to_deg(1e-6), 1e-2));
    }
  }
}

TEST(PaperMethod, FindsTheExtrinsicsThroughIndependentNoise) {
  for (const int configuration : {1, 2}) {
    for (const double angle_deg : {60.0, 90.0, 120.0}) {
      const auto clouds = clouds_of(configuration, angle_deg, false, 2);
      const auto found = calibrate_as_published(clouds.a.points, clouds.b.points);
      ASSERT_TRUE(found) << found.error().what;
      EXPECT_TRUE(found->converged);
      EXPECT_LE(found->cost_after, found->cost_before);
      EXPECT_THAT(found->T_a_b, SE3Near(sim::paper_configuration(configuration), 0.4, 30.0));
    }
  }
}

TEST(PaperMethod, SaysWhichCloudHasNoCorner) {
  const auto clouds = clouds_of(2, 80.0, false, 3);
  std::vector<Vector3d> walls;
  for (std::size_t k = 0; k < clouds.b.points.size(); ++k) {
    if (clouds.b.plane[k] == 0 || clouds.b.plane[k] == 1) walls.push_back(clouds.b.points[k]);
  }
  const auto found = calibrate_as_published(clouds.a.points, walls);
  ASSERT_FALSE(found);
  EXPECT_NE(found.error().message().find("second cloud: only 2 of the three planes"), std::string::npos);
}

TEST(PaperMethod, StartsFromWhatTheNormalsAndTheCornerSay) {
  const auto clouds = clouds_of(1, 100.0, false, 4);
  const auto corner_of = [](const std::vector<Vector3d>& cloud) {
    const std::vector<FittedPlane> planes = ransac_planes(cloud, RansacOptions{});
    return make_corner({planes.at(0), planes.at(1), planes.at(2)}, Vector3d::UnitZ());
  };
  const Expected<Corner> a = corner_of(clouds.a.points);
  const Expected<Corner> b = corner_of(clouds.b.points);
  ASSERT_TRUE(a && b);
  EXPECT_THAT(corner_alignment(*a, *b), SE3Near(sim::paper_configuration(1), 0.6, 60.0));
}

}  // namespace
}  // namespace rigcal
