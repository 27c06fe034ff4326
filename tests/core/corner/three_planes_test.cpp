#include "core/corner/three_planes.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "simdata/targets/corner_clouds.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

FittedPlane plane_of(const Vector3d& normal, double offset_m) {
  FittedPlane plane;
  plane.normal = normal.normalized();
  plane.offset_m = offset_m / normal.norm();
  return plane;
}

// The noise-free planes of the paper's corner, in the frame of LiDAR a or, by its inverse, of b.
ThreePlanes corner_planes(double angle_deg, const SE3& T_sensor_a) {
  const double half = 0.5 * to_rad(angle_deg);
  const Vector3d o(10.0 * std::cos(half), 0.0, -5.0);
  const Vector3d normals[] = {
      {-std::sin(half), -std::cos(half), 0.0}, {-std::sin(half), std::cos(half), 0.0}, Vector3d::UnitZ()};
  ThreePlanes planes;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector3d n = T_sensor_a.R * normals[k];
    planes[k] = plane_of(n, n.dot(T_sensor_a * o));
  }
  return planes;
}

TEST(ThreePlanes, MeetInThePointThatLiesOnAll) {
  const ThreePlanes planes = corner_planes(75.0, SE3{});
  const auto o = intersection(planes);
  ASSERT_TRUE(o);
  for (const FittedPlane& plane : planes) EXPECT_NEAR(plane.distance(*o), 0.0, 1e-12);
  EXPECT_NEAR((*o - Vector3d(10.0 * std::cos(to_rad(37.5)), 0.0, -5.0)).norm(), 0.0, 1e-12);
}

TEST(ThreePlanes, AreRefusedInWordsWhereTwoAreNearlyParallelOrAllShareADirection) {
  const ThreePlanes parallel{plane_of({1, 0, 0}, 1), plane_of({1, 0.05, 0}, 2), plane_of({0, 0, 1}, 3)};
  const auto refused = intersection(parallel);
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().what.find("nearly parallel"), std::string::npos);
  EXPECT_NE(refused.error().what.find("2.9 degrees"), std::string::npos);
  const ThreePlanes prism{plane_of({1, 0, 0}, 1), plane_of({-0.5, 0.8, 0}, 2), plane_of({-0.5, -0.8, 0.01}, 3)};
  EXPECT_FALSE(intersection(prism));
}

TEST(ThreePlanes, HaveNormalsOfWhichMinusOIsAPositiveCombination) {
  ThreePlanes planes = corner_planes(110.0, SE3{});
  planes[0] = planes[0].flipped();
  planes[2] = planes[2].flipped();
  const auto o = intersection(planes);
  ASSERT_TRUE(o);
  const ThreePlanes turned = with_oriented_normals(planes, *o);
  const ThreePlanes expected = corner_planes(110.0, SE3{});
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_LT((turned[k].normal - expected[k].normal).norm(), 1e-12);
    EXPECT_NEAR(turned[k].distance(*o), 0.0, 1e-12);
  }
}

TEST(ThreePlanes, ComeInTheOrderLeftRightBottomHoweverTheyWereFound) {
  const ThreePlanes expected = corner_planes(80.0, SE3{});
  std::array<std::size_t, 3> order{0, 1, 2};
  do {
    const ThreePlanes shuffled{expected[order[0]], expected[order[1]], expected[order[2]]};
    const ThreePlanes found = in_order(shuffled, Vector3d::UnitZ());
    for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(found[k].normal, expected[k].normal);
    EXPECT_GT(found[1].normal.cross(found[0].normal).dot(found[2].normal), 0.0);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(ThreePlanes, GiveTheExtrinsicsOfThePaperExactly) {
  for (const int number : {1, 2}) {
    const SE3 T_a_b = sim::paper_configuration(number);
    for (double angle_deg = 60.0; angle_deg <= 120.0; angle_deg += 10.0) {
      const auto a = make_corner(corner_planes(angle_deg, SE3{}), Vector3d::UnitZ());
      const auto b = make_corner(corner_planes(angle_deg, T_a_b.inverse()), Vector3d::UnitZ());
      ASSERT_TRUE(a && b);
      EXPECT_THAT(corner_alignment(*a, *b), SE3Near(T_a_b, 1e-9, 1e-9)) << number << ", " << angle_deg;
    }
  }
}

TEST(ThreePlanes, GiveAnyExtrinsicsWhereGravityTellsTheBottom) {
  Random random(3);
  for (int k = 0; k < 100; ++k) {
    const SE3 T_a_b = random_pose(random, 2.0, 0.3);
    const SE3 T_b_a = T_a_b.inverse();
    const auto a = make_corner(corner_planes(90.0, SE3{}), Vector3d::UnitZ());
    const auto b = make_corner(corner_planes(90.0, T_b_a), T_b_a.R * Vector3d::UnitZ());
    ASSERT_TRUE(a && b);
    EXPECT_THAT(corner_alignment(*a, *b), SE3Near(T_a_b, 1e-9, 1e-8));
  }
}

}  // namespace
}  // namespace rigcal
