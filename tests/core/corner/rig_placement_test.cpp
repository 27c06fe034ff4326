#include "core/corner/rig_placement.h"

#include <gtest/gtest.h>

#include "simdata/targets/corner_clouds.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"
#include "tests/support/stone_field.h"

namespace rigcal {
namespace {

PlaneView view_of(const std::vector<Vector3d>& points) { return plane_view(plane_cloud(points)); }

// Two views of the paper's corner, with the noise of a LiDAR of today.
struct Seen {
  sim::CornerClouds clouds;
  PlaneView a;
  PlaneView b;
};

Seen see(double angle_deg, const SE3& T_a_b, std::uint64_t seed) {
  Seen out;
  out.clouds = sim::make_corner_clouds(
      {.angle_deg = angle_deg, .sigma_m = 0.02, .stray_points = 1000, .T_a_b = T_a_b, .seed = seed});
  out.a = view_of(out.clouds.a.points);
  out.b = view_of(out.clouds.b.points);
  return out;
}

TEST(PlacePair, FindsAnyMountingWithoutAGuess) {
  Random random(11);
  for (std::uint64_t k = 0; k < 12; ++k) {
    const SE3 T_a_b = random_pose(random, 2.0, 0.5);
    const Seen seen = see(75.0, T_a_b, k);
    const PairPlacement placed = place_pair(seen.a, seen.b, std::nullopt);
    ASSERT_TRUE(placed.found) << placed.why_not;
    EXPECT_THAT(placed.T_a_b, SE3Near(T_a_b, 0.1, 10.0));
    EXPECT_GE(placed.matches.size(), 3U);
    EXPECT_LT(placed.runner_up_score, 0.7 * placed.score);
    EXPECT_FALSE(placed.by_shapes);
  }
}

TEST(PlacePair, ReportsTheOtherOrdersOfARightAngledCornerUnlessGravityOrAGuessTells) {
  Random random(12);
  const SE3 T_a_b = random_pose(random, 1.5, 0.5);
  Seen seen = see(90.0, T_a_b, 3);
  const PairPlacement open = place_pair(seen.a, seen.b, std::nullopt);
  ASSERT_TRUE(open.found);
  EXPECT_GT(open.runner_up_score, 0.95 * open.score);

  const SE3 guess = T_a_b * SE3{exp_so3(Vector3d(0.4, -0.5, 0.4)), Vector3d(0.2, 0.1, 0.0)};
  const PairPlacement guessed = place_pair(seen.a, seen.b, guess);
  ASSERT_TRUE(guessed.found);
  EXPECT_THAT(guessed.T_a_b, SE3Near(T_a_b, 0.1, 10.0));
  EXPECT_LT(guessed.runner_up_score, 0.9 * guessed.score);

  seen.a.up = Vector3d::UnitZ();
  seen.b.up = Vector3d(T_a_b.R.transpose() * Vector3d::UnitZ());
  const PairPlacement level = place_pair(seen.a, seen.b, std::nullopt);
  ASSERT_TRUE(level.found);
  EXPECT_THAT(level.T_a_b, SE3Near(T_a_b, 0.1, 10.0));
  EXPECT_LT(level.runner_up_score, 0.9 * level.score);
}

TEST(PlacePair, SaysInWordsWhyTwoWallsOrParallelPlanesAreNoCorner) {
  const SE3 T_a_b = sim::paper_configuration(2);
  const Seen seen = see(80.0, T_a_b, 4);
  std::vector<Vector3d> walls;
  for (std::size_t k = 0; k < seen.clouds.b.points.size(); ++k) {
    if (seen.clouds.b.plane[k] != 2) walls.push_back(seen.clouds.b.points[k]);
  }
  const PairPlacement two = place_pair(seen.a, view_of(walls), T_a_b);
  EXPECT_FALSE(two.found);
  EXPECT_NE(two.why_not.find("only 2 of at least three planes found in what {b} saw"), std::string::npos);

  Random random(6);
  std::vector<Vector3d> floors;
  for (int k = 0; k < 9000; ++k) {
    floors.emplace_back(random.uniform(-4.0, 4.0), random.uniform(-4.0, 4.0), -1.5 + k % 3 + 0.01 * random.normal());
  }
  const PairPlacement parallel = place_pair(view_of(floors), seen.b, std::nullopt);
  EXPECT_FALSE(parallel.found);
  EXPECT_NE(parallel.why_not.find("nearly parallel"), std::string::npos) << parallel.why_not;
}

TEST(PlaceRig, JoinsLidarsOfWhichSomeSeeNothingOfTheBase) {
  // c sees another corner than the base does; b sees both.
  Random random(21);
  const SE3 T_a_b = random_pose(random, 0.8, 0.4);
  const SE3 T_b_c = random_pose(random, 0.8, 0.4);
  const Seen ab = see(75.0, T_a_b, 5);
  const Seen bc = see(105.0, T_b_c, 6);
  RigViews views;
  views.names = {"a", "b", "c"};
  views.stops.resize(2);
  views.stops[0] = {ab.a, ab.b, std::nullopt};
  views.stops[1] = {std::nullopt, bc.a, bc.b};
  const RigPlacement placed = place_rig(views, {SE3{}, std::nullopt, std::nullopt});
  ASSERT_TRUE(placed.lidars[1].known && placed.lidars[2].known);
  EXPECT_EQ(placed.lidars[2].via, 1);
  EXPECT_EQ(placed.lidars[2].stop, 1);
  EXPECT_THAT(placed.state.T_base_sensor[1], SE3Near(T_a_b, 0.03, 3.0));
  EXPECT_THAT(placed.state.T_base_sensor[2], SE3Near(T_a_b * T_b_c, 0.05, 6.0));
  EXPECT_EQ(placed.features.size(), 6U);
  EXPECT_LT(placed.misfit, 2.5);
}

TEST(PlaceRig, BelievesMostStopsAndNotTheFirstThatIsSure) {
  const SE3 T_a_b = sim::paper_configuration(2);
  const SE3 wrong{T_a_b.R, T_a_b.t + Vector3d(1.6, 1.4, 1.5)};
  RigViews views;
  views.names = {"a", "b"};
  for (std::uint64_t k = 0; k < 3; ++k) {
    const Seen seen = see(k == 0 ? 75.0 : 100.0 + 7.0 * static_cast<double>(k), k == 0 ? wrong : T_a_b, 5 + k);
    views.stops.push_back({seen.a, seen.b});
  }
  for (const std::optional<SE3>& guess : {std::optional<SE3>(), std::optional<SE3>(T_a_b)}) {
    const RigPlacement placed = place_rig(views, {SE3{}, guess});
    ASSERT_TRUE(placed.lidars[1].known);
    EXPECT_GT(placed.lidars[1].stop, 0);
    EXPECT_THAT(placed.state.T_base_sensor[1], SE3Near(T_a_b, 0.1, 10.0));
  }
}

TEST(PlaceRig, WhatLiesByPlanesOnOneThatShapesHoldFollowsIt) {
  Random random(22);
  const SE3 T_a_b = random_pose(random, 0.1, 0.3);
  const SE3 T_a_c = random_pose(random, 0.8, 0.4);
  const SE3 T_b_d = random_pose(random, 0.8, 0.4);
  const Seen ac = see(75.0, T_a_c, 5);
  const Seen bd = see(105.0, T_b_d, 6);
  RigViews views;
  views.names = {"a", "b", "c", "d"};
  views.stops.resize(3);
  views.stops[0] = {view_of(see_stone_field(SE3{}, random)), view_of(see_stone_field(T_a_b, random)), std::nullopt,
                    std::nullopt};
  views.stops[1] = {ac.a, std::nullopt, ac.b, std::nullopt};
  views.stops[2] = {std::nullopt, bd.a, std::nullopt, bd.b};
  const RigPlacement placed = place_rig(views, {SE3{}, T_a_b, std::nullopt, std::nullopt});
  ASSERT_TRUE(placed.lidars[1].known && placed.lidars[2].known && placed.lidars[3].known);
  ASSERT_TRUE(placed.lidars[1].pair.by_shapes);
  EXPECT_EQ(placed.lidars[3].via, 1);
  EXPECT_FALSE(placed.lidars[3].pair.by_shapes);
  EXPECT_TRUE(placed.lidars[1].follows && placed.lidars[3].follows);
  EXPECT_FALSE(placed.lidars[2].follows);
  EXPECT_EQ(placed.layout.lidar_index(3), -1);
  EXPECT_TRUE(placed.adjusted.converged);
  EXPECT_THAT(placed.state.T_base_sensor[2], SE3Near(T_a_c, 0.03, 3.0));
  EXPECT_THAT(placed.state.T_base_sensor[1].inverse() * placed.state.T_base_sensor[3], SE3Near(T_b_d, 0.1, 10.0));
}

TEST(PlaceRig, LeavesOutWhoSawNothingAndSaysSo) {
  const Seen seen = see(75.0, sim::paper_configuration(2), 7);
  RigViews views;
  views.names = {"a", "b"};
  views.stops = {{seen.a, std::nullopt}};
  const RigPlacement placed = place_rig(views, {SE3{}, std::nullopt});
  EXPECT_FALSE(placed.lidars[1].known);
  EXPECT_NE(placed.lidars[1].why_not.find("saw anything"), std::string::npos);
  EXPECT_TRUE(placed.features.empty());
}

TEST(CommonPlanes, DoNotDependOnNoiseThatBothCloudsShare) {
  for (const double angle_deg : {60.0, 90.0, 120.0}) {
    const SE3 T_a_b = sim::paper_configuration(1);
    const auto clouds = sim::make_corner_clouds({.angle_deg = angle_deg, .T_a_b = T_a_b, .shared_noise = true});
    RigViews views;
    views.names = {"a", "b"};
    PlaneView a = view_of(clouds.a.points);
    PlaneView b = view_of(clouds.b.points);
    a.up = Vector3d::UnitZ();
    b.up = Vector3d(T_a_b.R.transpose() * Vector3d::UnitZ());
    views.stops = {{a, b}};
    const RigPlacement placed = place_rig(views, {SE3{}, std::nullopt});
    ASSERT_TRUE(placed.lidars[1].known);
    EXPECT_THAT(placed.state.T_base_sensor[1], SE3Near(T_a_b, to_deg(1e-4), 1.0)) << angle_deg;
  }
}

}  // namespace
}  // namespace rigcal
