#include "core/start/rig_start.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <optional>
#include <stop_token>

#include "core/base/parallel.h"
#include "simdata/scene/scene_file.h"
#include "tests/core/start/light_run.h"
#include "tests/support/court_of_walls.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

// A courtyard with walking people, seen by an AVIA and three MID-40 from a table turned by hand; every guess is off by
// 10 degrees and 0.2 m.
struct Courtyard : LightRun {
  explicit Courtyard(std::uint64_t seed, int stops = 20,
                     const std::optional<std::array<double, 2>>& step_range_deg = std::nullopt)
      : LightRun(seen(seed, stops, step_range_deg)) {
    for (std::size_t i = 0; i < truth.rig.sensors.size(); ++i)
      input.guess_T_base_sensor[i] = truth.rig.sensors[i].initial_T_base_sensor;
    input.axis = truth.axis;
  }

 private:
  static sim::LightRig seen(std::uint64_t seed, int stops, const std::optional<std::array<double, 2>>& step_range_deg) {
    const auto scene = sim::load_scene("courtyard");
    EXPECT_TRUE(scene.has_value());
    sim::LightRigOptions options;
    options.seed = seed;
    options.turntable.stops = stops;
    options.turntable.step_range_deg = step_range_deg;
    options.shots_per_patch = shots_per_patch;
    auto light = sim::make_light_rig(*scene, options);
    EXPECT_TRUE(light.has_value());
    return *std::move(light);
  }
};

Start found(const Courtyard& run) {
  SilentReporter reporter;
  const auto start = find_start(run.input, run.surfels, RunContext{reporter});
  EXPECT_TRUE(start.has_value());
  return *start;
}

void expect_all_found(const Courtyard& run, const Start& start, double deg = 0.3) {
  // What the refinement starts from must be right to a few centimetres.
  for (std::size_t j = 0; j < run.truth.T_G_base.size(); ++j) {
    EXPECT_TRUE(start.stop_known[j]);
    EXPECT_THAT(start.state.T_G_base[j], SE3Near(run.truth.T_G_base[j], deg, 30.0)) << "stop " << j;
  }
  for (std::size_t i = 0; i < run.truth.T_base_sensor.size(); ++i) {
    EXPECT_TRUE(start.lidar_known[i]);
    EXPECT_THAT(start.state.T_base_sensor[i], SE3Near(run.truth.T_base_sensor[i], deg, 30.0)) << "lidar " << i;
  }
}

class FindStartIn : public ::testing::TestWithParam<std::uint64_t> {};

TEST_P(FindStartIn, IsRightToThreeCentimetresWithAGyro) {
  Courtyard run(GetParam());
  run.give_gyro();
  expect_all_found(run, found(run));
}

TEST_P(FindStartIn, IsRightToThreeCentimetresWithoutAGyro) {
  const Courtyard run(GetParam());
  const Start start = found(run);
  EXPECT_FALSE(start.has_assumed_steps);
  expect_all_found(run, start);
}

INSTANTIATE_TEST_SUITE_P(Courtyards, FindStartIn, ::testing::Values(1, 2));

// The base sees nothing from one stop that it sees from the next; what the others saw tells that the table turned all
// round in equal steps, whichever way its axis is said to point. They are off by a degree.
TEST(FindStart, FindsStopsThatTheBaseCannotLayOnEachOther) {
  for (const std::uint64_t seed : {1, 2}) {
    Courtyard run(seed, 5);
    for (const double way : {1.0, -1.0}) {
      run.input.axis = way * run.truth.axis;
      const Start start = found(run);
      EXPECT_TRUE(start.has_assumed_steps);
      expect_all_found(run, start, 0.6);
    }
  }
}

TEST(FindStart, FindsStepsThatAreUnlikeEachOther) {
  const Courtyard run(1, 12, {{15.0, 45.0}});
  const Start start = found(run);
  EXPECT_FALSE(start.has_assumed_steps);
  expect_all_found(run, start);
}

// As where the base leans, and its rig file tells the axis as if it stood upright.
TEST(FindStart, FindsAnotherAxisThanWasTold) {
  Courtyard run(1, 12);
  EXPECT_FALSE(found(run).other_axis);
  for (const double off_deg : {10.0, 90.0}) {
    run.input.axis = exp_so3(to_rad(off_deg) * Vector3d::UnitY()) * run.truth.axis;
    const Start start = found(run);
    EXPECT_FALSE(start.has_assumed_steps);
    expect_all_found(run, start);
    ASSERT_TRUE(start.other_axis);
    EXPECT_LT(start.other_axis->cross(run.truth.axis).norm(), std::sin(to_rad(1.0)));
  }
}

TEST(FindStart, AssumesNoFullTurnWhereMoreStopsAreToCome) {
  Courtyard run(1, 5);
  run.input.goes_on = true;
  EXPECT_FALSE(found(run).has_assumed_steps);
}

// Unless all lies on itself, or all steps were told.
TEST(FindStart, SaysThatStepsWereAssumedAlsoWithoutAnAxis) {
  Courtyard run(1, 5, std::array{20.0, 40.0});
  run.input.axis.reset();
  EXPECT_TRUE(found(run).has_assumed_steps);
  run.input.turned_rad.emplace_back();
  for (const Vector3d& step : run.truth.step_rotations) run.input.turned_rad.emplace_back(step.norm());
  EXPECT_FALSE(found(run).has_assumed_steps);
  Courtyard all_round(1, 20);
  all_round.input.axis.reset();
  EXPECT_FALSE(found(all_round).has_assumed_steps);
  // The first eight of twenty, as while they are recorded: no full turn yet.
  Courtyard in_part(1, 8, std::array{18.0, 18.0});
  in_part.input.axis.reset();
  in_part.input.goes_on = true;
  EXPECT_TRUE(found(in_part).has_assumed_steps);
}

// What was seen six times from one place lies on itself, too; LiDARs that look apart came to stand half a turn off.
TEST(FindStart, SaysThatStepsWereAssumedWhereTheTableStood) {
  const auto scene = sim::load_scene("room");
  ASSERT_TRUE(scene);
  sim::LightRigOptions options;
  options.turntable.stops = 6;
  options.turntable.step_range_deg = {{0.0, 0.0}};
  options.shots_per_patch = 20000;
  options.mount_error = {0.1, 5.0};
  auto light = sim::make_light_rig(*scene, options);
  ASSERT_TRUE(light);
  LightRun run(*std::move(light));
  for (std::size_t i = 0; i < run.truth.rig.sensors.size(); ++i)
    run.input.guess_T_base_sensor[i] = run.truth.rig.sensors[i].initial_T_base_sensor;
  SilentReporter reporter;
  const auto start = find_start(run.input, run.surfels, RunContext{reporter});
  ASSERT_TRUE(start);
  EXPECT_TRUE(start->has_assumed_steps);
}

// Walls all around and a narrow view of them: held by what they saw alone, stops slid by a metre.
TEST(FindStart, DoesNotLetATableSlideAlongWalls) {
  const auto scene = sim::parse_scene(court_scene, "court");
  const auto rig = parse_rig(court_rig, "court rig");
  ASSERT_TRUE(scene && rig);
  for (const std::uint64_t seed : {3, 7}) {
    sim::LightRigOptions options;
    options.seed = seed;
    options.turntable.stops = 12;
    options.shots_per_patch = 40000;
    options.mount_error = {0.02, 1.0};
    auto light = sim::make_light_rig(*scene, options, *rig);
    ASSERT_TRUE(light);
    LightRun run(*std::move(light));
    run.input.axis = run.truth.axis;
    for (std::size_t i = 0; i < run.truth.rig.sensors.size(); ++i)
      run.input.guess_T_base_sensor[i] = run.truth.rig.sensors[i].initial_T_base_sensor;
    SilentReporter reporter;
    const auto start = find_start(run.input, run.surfels, RunContext{reporter});
    ASSERT_TRUE(start);
    int known = 0;
    for (std::size_t j = 0; j < run.truth.T_G_base.size(); ++j) {
      if (!start->stop_known[j]) continue;
      ++known;
      EXPECT_THAT(start->state.T_G_base[j], SE3Near(run.truth.T_G_base[j], 1.5, 60.0))
          << "seed " << seed << ", stop " << j;
    }
    EXPECT_GE(known, 10) << "seed " << seed;
  }
}

TEST(FindStart, TakesARoughTrajectoryInsteadOfAGyro) {
  Courtyard run(4);
  // Given in a frame of its own, some centimetres and half a degree off.
  Random random(40);
  const SE3 T_other_G = random_pose(random, 1.0, 10.0);
  for (const SE3& T : run.truth.T_G_base)
    run.input.trajectory.emplace_back(T_other_G * T * random_pose(random, to_rad(0.2), 0.02));
  const Start start = found(run);
  ASSERT_EQ(20U, start.given_T_G_base.size());
  EXPECT_THAT(start.given_T_G_base[0], SE3Near(SE3{}, 1e-9, 1e-9));
  expect_all_found(run, start);
}

TEST(FindStart, LeavesOutStopsThatARoughTrajectoryDoesNotKnow) {
  Courtyard run(8, 8);
  for (const SE3& T : run.truth.T_G_base) run.input.trajectory.emplace_back(T);
  run.input.trajectory[3].reset();
  const Start start = found(run);
  EXPECT_FALSE(start.stop_known[3]);
  EXPECT_THAT(start.state.T_G_base[3], SE3Near(SE3{}, 0.0, 0.0));
  // Its patches, which stand nowhere, spoil nothing.
  EXPECT_TRUE(start.stop_known[4]);
  EXPECT_THAT(start.state.T_G_base[4], SE3Near(run.truth.T_G_base[4], 0.3, 30.0));
  EXPECT_THAT(start.state.T_base_sensor[1], SE3Near(run.truth.T_base_sensor[1], 0.3, 30.0));
}

TEST(FindStart, FindsALidarWithoutAGuessAndLeavesOutOneThatSawNothing) {
  Courtyard run(5, 12);
  run.give_gyro();
  run.input.guess_T_base_sensor[1].reset();
  for (PatchSurfels& p : run.surfels) {
    if (p.lidar == 2) p.surfels.clear();
  }
  const Start start = found(run);
  EXPECT_TRUE(start.lidar_known[0]);
  EXPECT_TRUE(start.lidar_known[1]);
  EXPECT_FALSE(start.lidar_known[2]);
  EXPECT_TRUE(start.lidar_known[3]);
  EXPECT_THAT(start.state.T_base_sensor[1], SE3Near(run.truth.T_base_sensor[1], 0.3, 30.0));
  EXPECT_THAT(start.state.T_base_sensor[3], SE3Near(run.truth.T_base_sensor[3], 0.3, 30.0));
}

TEST(FindStart, IsTheSameToTheBitForOneAndTwoThreads) {
  Courtyard run(6, 8);
  run.give_gyro();
  set_thread_count(1);
  const Start one = found(run);
  set_thread_count(2);
  const Start two = found(run);
  for (std::size_t j = 0; j < 8; ++j) EXPECT_EQ(one.state.T_G_base[j].matrix(), two.state.T_G_base[j].matrix());
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(one.state.T_base_sensor[i].matrix(), two.state.T_base_sensor[i].matrix());
    EXPECT_EQ(one.matches[i].score, two.matches[i].score);
  }
}

TEST(FindStart, StopsWhenToldTo) {
  StartInput input;
  input.stops = 2;
  input.lidars = 1;
  input.guess_T_base_sensor = {SE3{}};
  SilentReporter reporter;
  std::stop_source stop;
  stop.request_stop();
  const auto start = find_start(input, {}, RunContext{reporter, stop.get_token()});
  ASSERT_FALSE(start.has_value());
  EXPECT_EQ(ErrorKind::cancelled, start.error().kind);
}

}  // namespace
}  // namespace rigcal
