#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "tests/core/pipeline/bare_scenes.h"
#include "tests/support/light_recording.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::AnyOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

struct Seen {
  LightRecording run;
  CalibrationResult result;
};

struct How {
  bool with_ground = true;
  bool with_guess = true;
  std::string table = "0.35, -0.25";
  bool is_plumb = false;  ///< The table's axis.
  bool with_poses = false;
  bool base_sees_ground = true;
};

void take_ground_from(int lidar, sim::LightRig& light) {
  constexpr double below_m = 0.2;
  for (Patch& patch : light.patches) {
    if (patch.sensor != lidar) continue;
    const SE3 T =
        light.T_G_base[static_cast<std::size_t>(patch.stop)] * light.T_base_sensor[static_cast<std::size_t>(lidar)];
    std::erase_if(patch.points, [&](const Point& p) { return (T * Vector3d(p.x, p.y, p.z)).z() < below_m; });
  }
}

Seen calibrate_in(const std::string& objects, const How& how) {
  const sim::Scene scene = bare_scene(objects, how.with_ground, how.table);
  sim::LightRigOptions options;
  options.turntable.stops = 12;
  if (how.is_plumb) options.turntable.axis_tilt_deg = 0.0;
  options.shots_per_patch = 8000;
  sim::LightRig light = *sim::make_light_rig(scene, options);
  if (!how.base_sees_ground) take_ground_from(0, light);
  Seen seen{make_light_recording(light), {}};
  if (how.with_poses) {
    seen.run.recording.trajectory.assign(seen.run.truth.T_G_base.begin(), seen.run.truth.T_G_base.end());
    seen.run.recording.trajectory_is_prior = true;
  }
  for (std::size_t i = 1; i < seen.run.guess.size() && !how.with_guess; ++i) seen.run.guess[i].reset();
  SilentReporter reporter;
  const auto result = calibrate_lidars(seen.run.rig, seen.run.recording, seen.run.guess, {}, RunContext{reporter});
  EXPECT_TRUE(result) << result.error().message();
  seen.result = *result;
  return seen;
}

template <class Matcher>
void expect_flagged(const Seen& seen, const Matcher& reason) {
  for (const SensorResult& sensor : seen.result.sensors) {
    if (sensor.name == seen.result.base) continue;
    EXPECT_NE(sensor.status, Status::good) << sensor.name;
    EXPECT_THAT(sensor.reasons, Contains(reason)) << sensor.name;
    // What nothing holds is not invented.
    EXPECT_EQ(sensor.T_base_sensor.has_value(), sensor.status != Status::failed) << sensor.name;
    ASSERT_FALSE(sensor.weak_directions.empty()) << sensor.name;
  }
}

void expect_right(const Seen& seen) {
  for (std::size_t i = 1; i < seen.result.sensors.size(); ++i) {
    const SensorResult& sensor = seen.result.sensors[i];
    EXPECT_EQ(sensor.status, Status::good) << testing::PrintToString(sensor.reasons);
    ASSERT_TRUE(sensor.T_base_sensor);
    EXPECT_LT((sensor.T_base_sensor->t - seen.run.truth.T_base_sensor[i].t).norm(), 0.005);
    EXPECT_LT(rotation_distance(sensor.T_base_sensor->R, seen.run.truth.T_base_sensor[i].R), to_rad(0.1));
  }
}

const auto height_is_open =
    AllOf(HasSubstr("z (up and down) of the base frame"), HasSubstr("a level surface (a floor, a ceiling, a table)"));

// The rig turns, so that one wall faces every level direction in some stop; none faces the height.
TEST(DegenerateScenes, OneWallLeavesTheHeightOpen) {
  expect_flagged(calibrate_in(wall(6.0, 0.0, 60.0, 12.0, 0.0), {.with_ground = false}), height_is_open);
}

TEST(DegenerateScenes, TwoParallelWallsLeaveTheHeightOpen) {
  expect_flagged(
      calibrate_in(wall(5.0, 0.0, 60.0, 12.0, 0.0) + wall(-5.0, 0.0, 60.0, 12.0, 0.0), {.with_ground = false}),
      height_is_open);
}

TEST(DegenerateScenes, WallsFarAwayLeaveTheHeightOpen) {
  std::string walls;
  for (const double azimuth : {0.0, 63.0, 132.0, 200.0, 281.0}) {
    walls += wall(45.0 * std::cos(to_rad(azimuth)), 45.0 * std::sin(to_rad(azimuth)), 12.0, 10.0, azimuth);
  }
  const Seen seen = calibrate_in(walls, {.with_ground = false});
  expect_flagged(seen, height_is_open);
  // What shapes tell to decimetres is kept, and nothing is fitted there.
  for (const SensorResult& sensor : seen.result.sensors) {
    if (sensor.name == seen.result.base) continue;
    EXPECT_TRUE(sensor.weak_directions[0].is_frozen) << sensor.name;
    EXPECT_GT(std::abs(sensor.weak_directions[0].axis.z()), 0.97) << sensor.name;
    EXPECT_GT(sensor.weak_directions[0].bound, 0.15) << sensor.name;
  }
}

// Poses that are given tell nothing of how high a LiDAR sits beside another, and a guess tells decimetres.
TEST(DegenerateScenes, WallsFarAwayLeaveTheHeightOpenWithGivenPosesToo) {
  std::string walls;
  for (const double azimuth : {0.0, 63.0, 132.0, 200.0, 281.0}) {
    walls += wall(45.0 * std::cos(to_rad(azimuth)), 45.0 * std::sin(to_rad(azimuth)), 12.0, 10.0, azimuth);
  }
  const Seen seen = calibrate_in(walls, {.with_ground = false, .with_poses = true});
  int placed = 0;
  for (const SensorResult& sensor : seen.result.sensors) {
    if (sensor.name == seen.result.base || !sensor.T_base_sensor) continue;
    EXPECT_THAT(sensor.reasons, Contains(HasSubstr("no surface faces z (up and down) of the base frame")))
        << sensor.name;
    EXPECT_GT(sensor.weak_directions[0].bound, 0.15) << sensor.name;
    ++placed;
  }
  EXPECT_GT(placed, 0);
}

// The floor that all LiDARs but the base see holds them to each other, not to the base.
TEST(DegenerateScenes, AFloorThatTheBaseDoesNotSeeLeavesItsHeightOpen) {
  const Seen seen = calibrate_in(walls_of_room(14.0, 9.0, 6.0), {.is_plumb = true, .base_sees_ground = false});
  for (std::size_t i = 1; i < seen.result.sensors.size(); ++i) EXPECT_NE(seen.result.sensors[i].status, Status::good);
  // Along it they may slide on for ever, which is told as well.
  EXPECT_THAT(seen.result.sensors[1].reasons, Contains(AnyOf(height_is_open, HasSubstr("did not come to rest"))));
}

// Level directions and the turn about the plumb line are open, the height is not.
const auto level_open = AllOf(
    HasSubstr("leave its place along all directions across z (up and down) of the base frame (all level ones) and its "
              "turn about z (up and down) of the base frame open; add upright flat surfaces that face two ways"));

TEST(DegenerateScenes, AFloorAloneLeavesLevelDirectionsOpen) {
  expect_flagged(calibrate_in(wall(300.0, 0.0, 0.1, 0.1, 0.0), {}), level_open);
}

TEST(DegenerateScenes, ARoundTankLeavesLevelDirectionsOpen) {
  expect_flagged(calibrate_in("  - {shape: cylinder, base: [0, 0, 0], length: 6, radius: 5, material: grey}\n", {}),
                 level_open);
}

std::string corridor() {
  return wall(0.0, 1.6, 100.0, 2.8, 90.0) + wall(0.0, -1.6, 100.0, 2.8, 90.0) + ceiling(2.8, 100.0, 3.2);
}

// Where a stop stands along a corridor is open, what the LiDARs have between them is not: each turn faces them anew.
TEST(DegenerateScenes, ACorridorIsEnoughForARigThatTurns) { expect_right(calibrate_in(corridor(), {})); }

TEST(DegenerateScenes, ASquareRoomIsEnoughWithAGuess) { expect_right(calibrate_in(walls_of_room(8.0, 8.0, 3.0), {})); }

// A quarter turn about its middle maps the room into itself, and all that was seen from there.
TEST(DegenerateScenes, InTheMiddleOfASquareRoomFourTurnsFitWithoutAGuess) {
  const Seen seen = calibrate_in(walls_of_room(8.0, 8.0, 3.0), {.with_guess = false, .table = "0, 0"});
  for (std::size_t i = 1; i < seen.result.sensors.size(); ++i) EXPECT_NE(seen.result.sensors[i].status, Status::good);
  for (const std::size_t i : {2U, 3U}) {
    EXPECT_THAT(seen.result.sensors[i].reasons, Contains(HasSubstr("the scene is symmetric")));
  }
}

TEST(DegenerateScenes, BesideTheMiddleOfASquareRoomNoGuessIsNeeded) {
  expect_right(calibrate_in(walls_of_room(8.0, 8.0, 3.0), {.with_guess = false}));
}

TEST(DegenerateScenes, InTheMiddleOfACorridorTwoTurnsFitWithoutAGuess) {
  const Seen seen = calibrate_in(corridor(), {.with_guess = false, .table = "0, 0", .is_plumb = true});
  for (std::size_t i = 1; i < seen.result.sensors.size(); ++i) {
    EXPECT_EQ(seen.result.sensors[i].status, Status::weak);
    EXPECT_THAT(seen.result.sensors[i].reasons, Contains(HasSubstr("another pose fits its surfaces nearly as well")));
  }
}

// The wrong turn would have the floor at a slant, which shows once the stops do not slide along the corridor.
TEST(DegenerateScenes, InTheMiddleOfACorridorATableThatIsNotPlumbNeedsNoGuess) {
  expect_right(calibrate_in(corridor(), {.with_guess = false, .table = "0, 0"}));
}

}  // namespace
}  // namespace rigcal
