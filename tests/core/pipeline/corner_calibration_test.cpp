#include "core/pipeline/corner_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/geometry/matrix6.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/quality/lidar_quality.h"
#include "core/voxel/patch_of_points.h"
#include "simdata/targets/corner_scans.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"
#include "tests/support/stone_field.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

// A rig of two LiDARs "front" (the base) and "side" in the paper's corner, with the noise of a LiDAR of today.
class CornerCalibrationTest : public ::testing::Test {
 protected:
  void see(const sim::CornerCloudOptions& options) { take(sim::make_corner_clouds(options)); }

  void take(const sim::CornerClouds& clouds) {
    rig_.name = "corner";
    rig_.sensors.resize(2);
    rig_.sensors[0].name = "front";
    rig_.sensors[1].name = "side";
    for (Sensor& sensor : rig_.sensors) sensor.lidar.emplace();
    recording_.lidar_sensors = {0, 1};
    recording_.stops = {{0, 0, 0}};
    recording_.patches = {patch_of(clouds.a.points, 0), patch_of(clouds.b.points, 1)};
  }

  static PatchCells patch_of(const std::vector<Vector3d>& points, int lidar) {
    CellOptions options;
    options.keep_thinned = true;
    return patch_of_points(points, lidar, 0, options);
  }

  [[nodiscard]] CalibrationResult calibrate() const {
    SilentReporter reporter;
    auto result = calibrate_by_planes(rig_, recording_, {SE3{}, guess_}, options_, {reporter});
    EXPECT_TRUE(result) << result.error().what;
    return result ? *result : CalibrationResult{};
  }

  Rig rig_;
  LidarRecording recording_;
  std::optional<SE3> guess_;
  CornerCalibrationOptions options_ = {{0.04, to_rad(0.1)}};  // what so few points tell of ranges
};

sim::CornerCloudOptions fine(double angle_deg, const SE3& T_a_b, std::uint64_t seed) {
  return {.angle_deg = angle_deg, .sigma_m = 0.01, .stray_points = 500, .T_a_b = T_a_b, .seed = seed};
}

TEST_F(CornerCalibrationTest, IsGoodOfOneMomentWithoutAGuessAndKnowsHowGood) {
  Random random(31);
  double nees = 0.0;
  constexpr int runs = 8;
  for (int k = 0; k < runs; ++k) {
    const SE3 T = random_pose(random, 2.0, 0.4);
    see(fine(75.0, T, static_cast<std::uint64_t>(k)));
    const CalibrationResult result = calibrate();
    ASSERT_EQ(result.sensors.size(), 2U);
    const SensorResult& side = result.sensors[1];
    EXPECT_EQ(side.status, Status::good) << testing::PrintToString(side.reasons);
    ASSERT_TRUE(side.T_base_sensor);
    EXPECT_THAT(*side.T_base_sensor, SE3Near(T, 0.03, 3.0));
    const Vector6d xi = (T.inverse() * *side.T_base_sensor).log();
    nees += xi.dot(solve_symmetric6(side.covariance, xi)) / (6.0 * runs);
    EXPECT_EQ(result.method, "planes");
    EXPECT_FALSE(result.map.empty());
    EXPECT_TRUE(result.trajectory[0].known);
  }
  EXPECT_GT(nees, 0.2);
  EXPECT_LT(nees, 2.0);
}

TEST_F(CornerCalibrationTest, IsWeakWhereAnotherOrderOfThePlanesFitsAsWell) {
  see(fine(90.0, sim::paper_configuration(1), 2));
  const CalibrationResult open = calibrate();
  EXPECT_EQ(open.status, Status::weak);
  EXPECT_THAT(open.sensors[1].reasons, testing::Contains(HasSubstr("another pose fits")));
  guess_ = SE3{exp_so3({0.0, 0.0, 2.4}), Vector3d::Zero()};
  const CalibrationResult guessed = calibrate();
  EXPECT_EQ(guessed.status, Status::good);
  EXPECT_THAT(*guessed.sensors[1].T_base_sensor, SE3Near(sim::paper_configuration(1), 0.03, 3.0));
}

// One of them sees less to either side, and in a wrong order more of what both saw overlaps, by a quarter and by a
// half.
TEST_F(CornerCalibrationTest, IsWeakWhereLessOfTheRightOrderOverlapsThanOfAWrongOne) {
  sim::CornerScanOptions options;
  options.field_b.half_width_rad = to_rad(45.0);
  for (const std::uint64_t seed : {12U, 328U}) {
    const bool first = seed == 12U;
    options.walls_m = first ? Vector3d(4.46, 3.45, 2.19) : Vector3d(4.37, 3.78, 1.69);
    options.T_a_b = first ? SE3{exp_so3({-0.29, -0.14, 0.84}), {0.12, 0.53, -0.28}}
                          : SE3{exp_so3({0.47, -0.16, 0.76}), {-0.15, 0.31, 0.02}};
    options.seed = seed;
    take(sim::make_corner_scans(options));
    guess_.reset();
    const SensorResult open = calibrate().sensors[1];
    ASSERT_TRUE(open.T_base_sensor);
    EXPECT_GT((open.T_base_sensor->t - options.T_a_b.t).norm(), 1.0);
    EXPECT_EQ(open.status, Status::weak);
    EXPECT_THAT(open.reasons, testing::Contains(HasSubstr("another pose fits")));
    guess_ = options.T_a_b * SE3{exp_so3({0.4, -0.5, 0.4}), {0.2, 0.1, 0.0}};
    const SensorResult guessed = calibrate().sensors[1];
    EXPECT_EQ(guessed.status, Status::good) << testing::PrintToString(guessed.reasons);
    EXPECT_THAT(*guessed.T_base_sensor, SE3Near(options.T_a_b, 0.1, 10.0));
  }
}

TEST_F(CornerCalibrationTest, KnowsThatTheRangesOfAUnitMayBeOff) {
  sim::CornerScanOptions scan;
  scan.angle_deg = 80.0;
  scan.T_a_b = {exp_so3({0.05, -0.04, 0.3}), {0.1, 0.5, -0.1}};
  scan.rays = 24000;
  scan.b_too_long_m = 0.01;
  guess_ = scan.T_a_b;
  options_ = {};
  take(sim::make_corner_scans(scan));
  const SensorResult side = calibrate().sensors[1];
  ASSERT_TRUE(side.T_base_sensor);
  const double error_m = (side.T_base_sensor->t - scan.T_a_b.t).norm();
  EXPECT_GT(error_m, options_.require.translation_m);
  EXPECT_GT(translation_bound(side.covariance), error_m);
  EXPECT_EQ(side.status, Status::weak);
  EXPECT_THAT(side.reasons, testing::Contains(HasSubstr("the ranges of the LiDARs may be off by")));
  scan.b_too_long_m = 0.02;
  take(sim::make_corner_scans(scan));
  EXPECT_THAT(calibrate().sensors[1].reasons,
              testing::Contains(HasSubstr("noise explains; the LiDARs measure ranges differently")));
}

TEST_F(CornerCalibrationTest, FailsInWordsWithoutACorner) {
  see(fine(75.0, sim::paper_configuration(2), 3));
  // Nothing but the floor is left to the side LiDAR.
  std::vector<Vector3d> floor;
  const auto clouds = sim::make_corner_clouds(fine(75.0, sim::paper_configuration(2), 3));
  for (std::size_t k = 0; k < clouds.b.points.size(); ++k) {
    if (clouds.b.plane[k] == 2) floor.push_back(clouds.b.points[k]);
  }
  recording_.patches[1] = patch_of(floor, 1);
  const CalibrationResult result = calibrate();
  EXPECT_EQ(result.status, Status::failed);
  EXPECT_FALSE(result.sensors[1].T_base_sensor);
  ASSERT_EQ(result.sensors[1].reasons.size(), 1U);
  EXPECT_THAT(result.sensors[1].reasons[0], HasSubstr("only 1 of at least three planes found in what side saw"));
  recording_.patches.pop_back();
  EXPECT_THAT(calibrate().sensors[1].reasons[0], HasSubstr("it has no points"));
  recording_.patches = {patch_of(floor, 1)};
  const CalibrationResult blind = calibrate();
  EXPECT_EQ(blind.sensors[0].status, Status::failed);
  EXPECT_FALSE(blind.sensors[0].T_base_sensor);
  EXPECT_THAT(blind.sensors[0].reasons[0], HasSubstr("or name another base"));
  EXPECT_THAT(blind.sensors[1].reasons[0], HasSubstr("front, the base, has no points in any stop"));
}

TEST_F(CornerCalibrationTest, FailsWhereTheTwoSeeDifferentPlaces) {
  see(fine(75.0, sim::paper_configuration(2), 4));
  const auto other = sim::make_corner_clouds(fine(115.0, SE3{}, 5));
  recording_.patches[1] = patch_of(other.a.points, 1);
  const CalibrationResult result = calibrate();
  EXPECT_EQ(result.sensors[1].status, Status::failed) << testing::PrintToString(result.sensors[1].reasons);
}

TEST_F(CornerCalibrationTest, WhatLiesOnOneWhosePlaceIsOneOfTwoIsWeak) {
  const SE3 T_side_rear = sim::paper_configuration(2);
  const auto beside = sim::make_corner_clouds(fine(75.0, T_side_rear, 7));
  for (const double angle_deg : {90.0, 105.0}) {
    see(fine(angle_deg, sim::paper_configuration(1), 2));
    rig_.sensors.push_back(rig_.sensors[1]);
    rig_.sensors[2].name = "rear";
    recording_.lidar_sensors = {0, 1, 2};
    recording_.stops = {{0, 0, 0}, {1, 0, 0}};
    recording_.patches.push_back(patch_of(beside.a.points, 1));
    recording_.patches.push_back(patch_of(beside.b.points, 2));
    for (std::size_t k : {2U, 3U}) recording_.patches[k].stop = 1;
    SilentReporter reporter;
    const auto result = calibrate_by_planes(rig_, recording_, {SE3{}, std::nullopt, std::nullopt}, {}, {reporter});
    ASSERT_TRUE(result);
    const SensorResult& rear = result->sensors[2];
    const auto says_so = testing::Contains(HasSubstr("it was laid on side, for whose own place another pose fits"));
    if (angle_deg == 90.0) {
      EXPECT_EQ(rear.status, Status::weak);
      EXPECT_THAT(rear.reasons, says_so);
    } else {
      EXPECT_EQ(rear.status, Status::good) << testing::PrintToString(rear.reasons);
    }
  }
}

// "front" and "side" share no corner, "rear" sees one with "side" only.
TEST_F(CornerCalibrationTest, WhatLiesOnOneThatShapesHoldIsWeakAndKnownNoBetter) {
  Random random(22);
  const SE3 T_side = random_pose(random, 0.1, 0.3);
  const SE3 T_side_rear = random_pose(random, 0.8, 0.4);
  see(fine(105.0, T_side_rear, 6));
  rig_.sensors.push_back(rig_.sensors[1]);
  rig_.sensors[2].name = "rear";
  recording_.lidar_sensors = {0, 1, 2};
  recording_.stops = {{0, 0, 0}, {1, 0, 0}};
  for (PatchCells& patch : recording_.patches) patch.lidar += 1;
  for (const int lidar : {0, 1}) {
    recording_.patches.push_back(patch_of(see_stone_field(lidar == 0 ? SE3{} : T_side, random), lidar));
    recording_.patches.back().stop = 1;
  }
  SilentReporter reporter;
  const auto result = calibrate_by_planes(rig_, recording_, {SE3{}, T_side, std::nullopt}, {}, {reporter});
  ASSERT_TRUE(result);
  const SensorResult& side = result->sensors[1];
  const SensorResult& rear = result->sensors[2];
  EXPECT_EQ(side.status, Status::weak) << testing::PrintToString(side.reasons);
  EXPECT_EQ(rear.status, Status::weak) << testing::PrintToString(rear.reasons);
  EXPECT_THAT(rear.reasons, testing::Contains(HasSubstr("it was laid on side, which no planes join with front")));
  ASSERT_TRUE(side.T_base_sensor && rear.T_base_sensor);
  EXPECT_THAT(side.T_base_sensor->inverse() * *rear.T_base_sensor, SE3Near(T_side_rear, 0.1, 10.0));
  EXPECT_GT(rotation_bound(rear.covariance), rotation_bound(side.covariance));
}

// "rear" lies by shapes on "side", which planes join with "front", and not very surely.
TEST_F(CornerCalibrationTest, WhatShapesLayOnOneThatPlanesHoldIsKnownNoBetterThanThatOne) {
  Random random(22);
  const SE3 T_side_rear = random_pose(random, 0.1, 0.3);
  see({.angle_deg = 75.0, .points = 1500, .sigma_m = 0.1, .T_a_b = sim::paper_configuration(2), .seed = 6});
  rig_.sensors.push_back(rig_.sensors[1]);
  rig_.sensors[2].name = "rear";
  recording_.lidar_sensors = {0, 1, 2};
  recording_.stops = {{0, 0, 0}, {1, 0, 0}};
  for (const int lidar : {1, 2}) {
    recording_.patches.push_back(patch_of(see_stone_field(lidar == 1 ? SE3{} : T_side_rear, random), lidar));
    recording_.patches.back().stop = 1;
  }
  SilentReporter reporter;
  const SE3 T_rear = sim::paper_configuration(2) * T_side_rear;
  const auto result = calibrate_by_planes(rig_, recording_, {SE3{}, std::nullopt, T_rear}, {}, {reporter});
  ASSERT_TRUE(result);
  const SensorResult& side = result->sensors[1];
  const SensorResult& rear = result->sensors[2];
  ASSERT_TRUE(side.T_base_sensor && rear.T_base_sensor) << testing::PrintToString(rear.reasons);
  const Matrix6d A = (rear.T_base_sensor->inverse() * *side.T_base_sensor).adjoint();
  const Matrix6d more = rear.covariance - A * side.covariance * A.transpose();
  EXPECT_GT(symmetric_eigen6(more).values[0], 0.0);
}

TEST_F(CornerCalibrationTest, CallsThoseStopsUsedThatHoldALidar) {
  see(fine(75.0, sim::paper_configuration(2), 3));
  recording_.stops = {{0, 0, 0}, {1, 0, 0}, {2, 0, 0}};
  for (PatchCells& patch : recording_.patches) patch.stop = 1;
  const auto few = [](const std::vector<Vector3d>& points) {
    return std::vector<Vector3d>(points.begin(), points.begin() + 20);
  };
  const auto clouds = sim::make_corner_clouds(fine(75.0, sim::paper_configuration(2), 3));
  for (const int stop : {0, 2}) {
    recording_.patches.push_back(patch_of(clouds.a.points, 0));
    recording_.patches.back().stop = stop;
    recording_.patches.push_back(patch_of(few(clouds.b.points), 1));
    recording_.patches.back().stop = stop;
  }
  const CalibrationResult result = calibrate();
  ASSERT_TRUE(result.sensors[1].T_base_sensor) << testing::PrintToString(result.sensors[1].reasons);
  EXPECT_FALSE(result.trajectory[0].is_used());
  EXPECT_TRUE(result.trajectory[1].known);
  EXPECT_FALSE(result.trajectory[2].is_used());
  EXPECT_FALSE(result.shared_surfaces.empty()) << "the stop that was used is the one to show";
}

TEST_F(CornerCalibrationTest, IsAnErrorWithoutAStopOrABase) {
  see(fine(75.0, SE3{}, 6));
  SilentReporter reporter;
  recording_.stops.clear();
  EXPECT_FALSE(calibrate_by_planes(rig_, recording_, {SE3{}, guess_}, CornerCalibrationOptions{}, {reporter}));
  see(fine(75.0, SE3{}, 6));
  recording_.lidar_sensors = {1};
  EXPECT_FALSE(calibrate_by_planes(rig_, recording_, {guess_}, CornerCalibrationOptions{}, {reporter}));
}

}  // namespace
}  // namespace rigcal
