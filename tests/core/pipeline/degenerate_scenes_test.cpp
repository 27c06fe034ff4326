#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "simdata/scene_file.h"
#include "tests/support/light_recording.h"

namespace rigcal {
namespace {

using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::Not;

// An upright rectangle facing along the level direction `facing_deg`, its foot on the ground.
std::string wall(double x, double y, double width, double height, double facing_deg) {
  return "  - {shape: rectangle, center: [" + std::to_string(x) + ", " + std::to_string(y) + ", " +
         std::to_string(0.5 * height) + "], size: [" + std::to_string(height) + ", " + std::to_string(width) +
         "], rpy_deg: [0, 90, " + std::to_string(facing_deg) + "], material: grey}\n";
}

struct Seen {
  LightRecording run;
  CalibrationResult result;
};

Seen calibrate_in(const std::string& objects, bool with_ground) {
  const std::string text = std::string("rigcal: 1\nname: bare\nmaterials:\n  grey: {reflectivity: 50}\n") +
                           "turntable: {position: [0.35, -0.25, 1.22], yaw_deg: -11}\n" +
                           (with_ground ? "ground: {height: 0, material: grey}\n" : "") + "objects:\n" + objects;
  const Expected<sim::Scene> scene = sim::parse_scene(text, "bare.yaml");
  EXPECT_TRUE(scene) << scene.error().message();
  sim::LightRigOptions options;
  options.turntable.stops = 12;
  options.shots_per_patch = 8000;
  Seen seen{make_light_recording(*sim::make_light_rig(*scene, options)), {}};
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

const std::string height_open = "z (up and down) of the base frame";

// The rig turns, so that one wall faces every level direction in some stop; none faces the height.
TEST(DegenerateScenes, OneWallLeavesTheHeightOpen) {
  expect_flagged(calibrate_in(wall(6.0, 0.0, 60.0, 12.0, 0.0), false), HasSubstr(height_open));
}

TEST(DegenerateScenes, TwoParallelWallsLeaveTheHeightOpen) {
  expect_flagged(calibrate_in(wall(5.0, 0.0, 60.0, 12.0, 0.0) + wall(-5.0, 0.0, 60.0, 12.0, 0.0), false),
                 HasSubstr(height_open));
}

TEST(DegenerateScenes, WallsFarAwayLeaveTheHeightOpen) {
  std::string walls;
  for (const double azimuth : {0.0, 63.0, 132.0, 200.0, 281.0}) {
    walls += wall(45.0 * std::cos(to_rad(azimuth)), 45.0 * std::sin(to_rad(azimuth)), 12.0, 10.0, azimuth);
  }
  expect_flagged(calibrate_in(walls, false), HasSubstr(height_open));
}

// Level directions and the turn about the plumb line are open, the height is not.
const auto level_open = AllOf(HasSubstr("leave its place along"), HasSubstr("open"), Not(HasSubstr("up and down")));

TEST(DegenerateScenes, AFloorAloneLeavesLevelDirectionsOpen) {
  expect_flagged(calibrate_in(wall(300.0, 0.0, 0.1, 0.1, 0.0), true), level_open);
}

TEST(DegenerateScenes, ARoundTankLeavesLevelDirectionsOpen) {
  expect_flagged(calibrate_in("  - {shape: cylinder, base: [0, 0, 0], length: 6, radius: 5, material: grey}\n", true),
                 level_open);
}

// Where a stop stands along a corridor is open, what the LiDARs have between them is not: each turn faces them anew.
TEST(DegenerateScenes, ACorridorIsEnoughForARigThatTurns) {
  expect_right(calibrate_in(wall(0.0, 1.6, 100.0, 2.8, 90.0) + wall(0.0, -1.6, 100.0, 2.8, 90.0) +
                                "  - {shape: rectangle, center: [0, 0, 2.8], size: [100, 3.2], material: grey}\n",
                            true));
}

TEST(DegenerateScenes, ASquareRoomIsEnoughWithAGuess) {
  expect_right(calibrate_in(wall(0.0, 4.0, 8.0, 3.0, 90.0) + wall(0.0, -4.0, 8.0, 3.0, 90.0) +
                                wall(4.0, 0.0, 8.0, 3.0, 0.0) + wall(-4.0, 0.0, 8.0, 3.0, 0.0) +
                                "  - {shape: rectangle, center: [0, 0, 3], size: [8, 8], material: grey}\n",
                            true));
}

}  // namespace
}  // namespace rigcal
