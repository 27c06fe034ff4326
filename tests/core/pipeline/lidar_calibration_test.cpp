#include "core/pipeline/lidar_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/geometry/matrix6.h"
#include "core/pipeline/lidar_result.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;

sim::LightRig make_courtyard(std::uint64_t seed, int stops = 12, double dark_bias_m = 0.0) {
  sim::LightRigOptions options;
  options.unit_errors.dark_bias_m = dark_bias_m;
  options.seed = seed;
  options.turntable.stops = stops;
  options.shots_per_patch = 20000;
  return *sim::make_light_rig(*sim::load_scene("courtyard"), options);
}

CalibrationResult calibrated(const LightRecording& run, const LidarCalibrationOptions& options = {}) {
  SilentReporter reporter;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, options, RunContext{reporter});
  EXPECT_TRUE(result) << result.error().message();
  return *result;
}

double shift_m(const LightRecording& run, const CalibrationResult& result, std::size_t lidar) {
  return (result.sensors[lidar].T_base_sensor->t - run.truth.T_base_sensor[lidar].t).norm();
}

double turn_deg(const LightRecording& run, const CalibrationResult& result, std::size_t lidar) {
  return to_deg(rotation_distance(result.sensors[lidar].T_base_sensor->R, run.truth.T_base_sensor[lidar].R));
}

void expect_right_and_good(const LightRecording& run, const CalibrationResult& result, double max_m = 0.003) {
  ASSERT_EQ(result.sensors.size(), run.truth.T_base_sensor.size());
  for (std::size_t i = 1; i < result.sensors.size(); ++i) {
    EXPECT_EQ(result.sensors[i].status, Status::good) << testing::PrintToString(result.sensors[i].reasons);
    ASSERT_TRUE(result.sensors[i].T_base_sensor);
    EXPECT_LT(shift_m(run, result, i), max_m);
    EXPECT_LT(turn_deg(run, result, i), 0.03);
  }
}

TEST(CalibrateLidars, FindsEveryLidarFromTenDegreesAndTwentyCentimetres) {
  const LightRecording run = make_light_recording(make_courtyard(1));
  const CalibrationResult result = calibrated(run);
  EXPECT_EQ(result.status, Status::good);
  EXPECT_EQ(result.base, run.rig.base_sensor().name);
  expect_right_and_good(run, result);
  std::vector<std::string> stages;
  for (const StageReport& stage : result.stages) stages.push_back(stage.name);
  EXPECT_THAT(stages, ElementsAre("start", "poses", "extrinsics", "joint", "joint over several grids", "verdict", "map",
                                  "comparison with the guess"));
  EXPECT_GT(result.map.size(), 100'000U);
  ASSERT_EQ(result.trajectory.size(), 12U);
  for (std::size_t j = 0; j < 12; ++j) {
    EXPECT_TRUE(result.trajectory[j].known);
    EXPECT_LT((result.trajectory[j].T_G_base.t - run.truth.T_G_base[j].t).norm(), 0.005);
  }
}

// As who links the library may hand it over: the program names every LiDAR of the rig.
TEST(CalibrateLidars, FailsALidarOfTheRigThatTheRecordingDoesNotName) {
  LightRecording run = make_light_recording(make_courtyard(1));
  const std::size_t absent = run.recording.lidar_sensors.size() - 1;
  run.recording.lidar_sensors.pop_back();
  run.guess.pop_back();
  std::erase_if(run.recording.patches,
                [&](const PatchCells& patch) { return static_cast<std::size_t>(patch.lidar) == absent; });
  const CalibrationResult result = calibrated(run);
  ASSERT_EQ(result.sensors.size(), absent + 1);
  EXPECT_EQ(result.sensors[absent].name, run.rig.sensors[absent].name);
  EXPECT_EQ(result.sensors[absent].status, Status::failed);
  EXPECT_FALSE(result.sensors[absent].T_base_sensor);
  EXPECT_THAT(result.sensors[absent].reasons, ElementsAre(HasSubstr("it has no points in any stop")));
  for (std::size_t i = 0; i < absent; ++i) EXPECT_EQ(result.sensors[i].status, Status::good) << i;
}

TEST(CalibrateLidars, SaysOfALidarThatSawNothingNearThatItSawTooFar) {
  LightRecording run = make_light_recording(make_courtyard(1));
  const int far = static_cast<int>(run.recording.lidar_sensors.size()) - 1;
  std::erase_if(run.recording.patches, [&](const PatchCells& patch) { return patch.lidar == far; });
  run.recording.too_far.assign(run.recording.stops.size(),
                               std::vector<std::uint64_t>(run.recording.lidar_sensors.size()));
  run.recording.too_far.front().back() = 5000;
  const CalibrationResult result = calibrated(run);
  EXPECT_EQ(result.sensors.back().status, Status::failed);
  EXPECT_THAT(result.sensors.back().reasons, ElementsAre(HasSubstr("all its points in range lie farther than 60 m")));
}

TEST(CalibrateLidars, FindsTheAxisThatWasToldWronglyAndSaysSo) {
  const sim::LightRig light = make_courtyard(1);
  LightRecording run = make_light_recording(light);
  run.recording.R_previous_this.clear();
  run.rig.turntable.emplace().axis = Vector3d(exp_so3(to_rad(20.0) * Vector3d::UnitY()) * light.axis);
  NotingReporter reporter;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter});
  ASSERT_TRUE(result);
  expect_right_and_good(run, *result);
  EXPECT_THAT(reporter.warnings, Contains(HasSubstr("20 degrees from the axis of the turntable in the rig file")));
}

// All that it saw fits, a step of the table off.
TEST(CalibrateLidars, SaysThatCloudsWereCountedFromAnotherNumberOn) {
  sim::LightRigOptions options;
  options.turntable.stops = 12;
  options.turntable.step_range_deg = {{20.0, 20.0}};
  options.shots_per_patch = 20000;
  const sim::LightRig light = *sim::make_light_rig(*sim::load_scene("courtyard"), options);
  LightRecording run = make_light_recording(light);
  run.recording.R_previous_this.clear();
  run.rig.turntable.emplace().axis = light.axis;
  run.recording.stops.push_back({12, 0, 0});
  for (PatchCells& patch : run.recording.patches) patch.stop += patch.lidar == 1 ? 1 : 0;
  const CalibrationResult result = calibrated(run);
  EXPECT_EQ(result.sensors[1].status, Status::weak);
  EXPECT_THAT(result.sensors[1].reasons,
              Contains(HasSubstr("its clouds are of stops 1 to 12, those of avia of stops 0 to 11")));
  EXPECT_EQ(result.sensors[2].status, Status::good) << testing::PrintToString(result.sensors[2].reasons);
}

TEST(CalibrateLidars, TellsWhatItChanged) {
  const LightRecording run = make_light_recording(make_courtyard(1));
  const CalibrationResult result = calibrated(run);
  for (const StageReport& stage : result.stages) {
    std::size_t iterations = 0;
    for (const std::vector<double>& pass : stage.costs) {
      ASSERT_FALSE(pass.empty());
      EXPECT_TRUE(std::is_sorted(pass.rbegin(), pass.rend())) << stage.name;
      iterations += pass.size() - 1;
    }
    EXPECT_EQ(static_cast<int>(iterations), stage.iterations) << stage.name;
  }
  ASSERT_FALSE(result.shared_surfaces.empty());
  const SharedSurfaces& all = result.shared_surfaces.back();
  EXPECT_EQ(all.first, "");
  EXPECT_GT(all.before_m, 0.1);
  EXPECT_LT(all.after_m, 0.005);
  EXPECT_EQ(result.cuts.size(), 3U);
  EXPECT_GT(result.map_at_guess.size(), 10'000U);
  for (const SensorResult& sensor : result.sensors) {
    ASSERT_TRUE(sensor.guess_T_base_sensor);
    if (sensor.name == result.base) continue;
    EXPECT_GT(sensor.hold_out.start_rms, 10.0 * sensor.hold_out.rms);
    EXPECT_GT(result.trajectory[0].points.at(sensor.name), 1000U);
  }
}

TEST(CalibrateLidars, ErrsAsMuchAsItSays) {
  double sum = 0.0;
  int count = 0;
  for (const std::uint64_t seed : {2, 3, 4}) {
    const LightRecording run = make_light_recording(make_courtyard(seed));
    const CalibrationResult result = calibrated(run);
    for (std::size_t i = 1; i < result.sensors.size(); ++i) {
      const Vector6d error = (result.sensors[i].T_base_sensor->inverse() * run.truth.T_base_sensor[i]).log();
      sum += error.dot(solve_symmetric6(result.sensors[i].covariance, error));
      count += 6;
    }
  }
  EXPECT_GT(sum / count, 0.2);
  EXPECT_LT(sum / count, 3.0);
}

TEST(CalibrateLidars, FindsALidarThatMeasuresFiveCentimetresTooFar) {
  sim::LightRig light = make_courtyard(11, 14);
  for (Patch& patch : light.patches) {
    if (patch.sensor != 2) continue;
    for (Point& p : patch.points) {
      const Eigen::Vector3f at(p.x, p.y, p.z);
      const Eigen::Vector3f moved = at + 0.05F * at.normalized();
      p.x = moved.x();
      p.y = moved.y();
      p.z = moved.z();
    }
  }
  const LightRecording run = make_light_recording(light);
  NotingReporter reporter;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter});
  ASSERT_TRUE(result);
  expect_right_and_good(run, *result, 0.004);
  ASSERT_TRUE(result->sensors[2].range_offset);
  EXPECT_NEAR(result->sensors[2].range_offset->value_m, 0.05, 4.0 * result->sensors[2].range_offset->sigma_m);
  EXPECT_LT(result->sensors[2].range_offset->sigma_m, 0.003);
  EXPECT_THAT(reporter.warnings, ElementsAre(HasSubstr(run.rig.sensors[2].name + " by ")));
}

TEST(CalibrateLidars, FindsThatDarkSurfacesSeemFarther) {
  const LightRecording run = make_light_recording(make_courtyard(1, 12, 0.015));
  NotingReporter reporter;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter});
  ASSERT_TRUE(result);
  expect_right_and_good(run, *result, 0.004);
  for (const SensorResult& sensor : result->sensors) {
    if (!sensor.range_offset) continue;
    ASSERT_TRUE(sensor.dark_offset) << sensor.name;
    EXPECT_NEAR(sensor.dark_offset->value_m, 0.015, 0.006) << sensor.name;
  }
  EXPECT_TRUE(result->sensors[0].dark_offset);
  EXPECT_THAT(reporter.warnings, ElementsAre(HasSubstr("what goes with reflectivity")));
}

// The world is where the first stop is that has a pose, also where the recording's first has none.
TEST(CalibrateLidars, BeginsTheTrajectoryAtTheFirstStopThatIsKnown) {
  LightRecording run = make_light_recording(make_courtyard(1, 8));
  std::erase_if(run.recording.patches, [](const PatchCells& patch) { return patch.stop == 0; });
  const CalibrationResult result = calibrated(run);
  ASSERT_FALSE(result.trajectory[0].known);
  for (std::size_t j = 1; j < 8; ++j) {
    const SE3 truth = run.truth.T_G_base[1].inverse() * run.truth.T_G_base[j];
    EXPECT_LT((result.trajectory[j].T_G_base.t - truth.t).norm(), 0.005);
  }
  EXPECT_EQ(result.trajectory[1].T_G_base.R, Matrix3d::Identity());
  EXPECT_EQ(result.trajectory[1].T_G_base.t, Vector3d::Zero());
}

TEST(CalibrateLidars, TakesNoRangeForWrongThatIsNot) {
  const LightRecording run = make_light_recording(make_courtyard(12));
  const CalibrationResult result = calibrated(run);
  for (const SensorResult& sensor : result.sensors) EXPECT_FALSE(sensor.range_offset) << sensor.name;
}

// The base looks forward, so stops a third of a turn apart share no surface that it sees; the others' view backwards
// joins them, but only once every stop stands about where it should.
TEST(CalibrateLidars, TwoGroupsOfStopsDoNotSlideApart) {
  for (const std::uint64_t seed : {2, 5}) {
    const sim::LightRig light = make_courtyard(seed);
    const LightRecording run = make_light_recording(light, {0, 3, 5, 6, 10, 11});
    const CalibrationResult result = calibrated(run);
    expect_right_and_good(run, result, 0.006);
    for (std::size_t j = 0; j < run.truth.T_G_base.size(); ++j) {
      EXPECT_LT((result.trajectory[j].T_G_base.t - run.truth.T_G_base[j].t).norm(), 0.01) << "stop " << j;
    }
  }
}

// One large step among small ones, and no gyro: both groups fix the LiDARs, and nothing but the floor joins them.
TEST(CalibrateLidars, StopsThatShareNothingWithTheOthersAreLeftOut) {
  const sim::LightRig light = make_courtyard(1, 16);
  LightRecording run = make_light_recording(light, {0, 1, 2, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15});
  run.rig.turntable.emplace().axis = light.axis;
  for (auto& R : run.recording.R_previous_this) R.reset();
  NotingReporter reporter;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter});
  ASSERT_TRUE(result);
  EXPECT_THAT(reporter.warnings, Contains(HasSubstr("left out: too little of what was seen from there")));
  const auto is_known = [](const StopPose& pose) { return pose.known; };
  const auto first = std::find_if(result->trajectory.begin(), result->trajectory.end(), is_known);
  const auto base = static_cast<std::size_t>(first - result->trajectory.begin());
  EXPECT_GE(std::count_if(result->trajectory.begin(), result->trajectory.end(), is_known), 8);
  for (std::size_t j = base; j < result->trajectory.size(); ++j) {
    if (!result->trajectory[j].known) continue;
    const SE3 truth = run.truth.T_G_base[base].inverse() * run.truth.T_G_base[j];
    EXPECT_THAT(result->trajectory[j].T_G_base, SE3Near(truth, 0.1, 10.0)) << "stop " << j;
  }
}

TEST(CalibrateLidars, ALidarWithoutPointsFailsAndTheOthersAreSolved) {
  LightRecording run = make_light_recording(make_courtyard(6));
  for (PatchCells& patch : run.recording.patches) {
    if (patch.lidar == 2) patch = PatchCells{2, patch.stop, 0, {}, {}, {}, 0};
  }
  const CalibrationResult result = calibrated(run);
  EXPECT_EQ(result.status, Status::failed);
  EXPECT_EQ(result.sensors[2].status, Status::failed);
  EXPECT_FALSE(result.sensors[2].T_base_sensor);
  EXPECT_THAT(result.sensors[2].reasons, ElementsAre(HasSubstr("no points in any stop")));
  EXPECT_EQ(result.sensors[1].status, Status::good);
  EXPECT_LT(shift_m(run, result, 1), 0.003);
}

// Its lens is covered, say. The others lie on each other as the guesses have it, which says nothing of the base.
TEST(CalibrateLidars, ABaseWithoutPointsFailsAndIsTheReasonOfTheOthers) {
  LightRecording run = make_light_recording(make_courtyard(6, 6));
  const int base = run.rig.base;
  for (PatchCells& patch : run.recording.patches) {
    if (patch.lidar == base) patch = PatchCells{base, patch.stop, 0, {}, {}, {}, 0};
  }
  const CalibrationResult result = calibrated(run);
  for (const SensorResult& sensor : result.sensors) {
    EXPECT_EQ(sensor.status, Status::failed) << sensor.name;
    EXPECT_FALSE(sensor.T_base_sensor) << sensor.name;
    const std::string reason =
        sensor.name == result.base ? "or name another base" : result.base + ", the base, has no points in any stop";
    EXPECT_THAT(sensor.reasons, ElementsAre(HasSubstr(reason)));
  }
}

// What it saw in a few stops is known no better by what others saw in more.
TEST(JudgeSolution, TakesTheStopsOfEachLidarByItself) {
  const LightRecording run = make_light_recording(make_courtyard(6, 8));
  SilentReporter reporter;
  std::unique_ptr<LidarSolution> solution;
  ASSERT_TRUE(calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter}, &solution));
  const auto judged = [&] {
    return judge_solution(run.rig, run.recording, run.rig.base, run.guess, {}, *solution,
                          weigh_solution(run.rig.base, run.guess, *solution));
  };
  constexpr double unevenness_m = 0.01;
  solution->unevenness_m = 0.0;
  const double even = judged().sensors[3].covariance(3, 3);
  solution->unevenness_m = unevenness_m;
  EXPECT_NEAR(judged().sensors[3].covariance(3, 3) - even, unevenness_m * unevenness_m / 8.0, 1e-9);
  const auto leave_out = [&](std::size_t stops) {
    for (std::size_t k = 0; k < solution->use.size(); ++k) {
      const PatchCells& patch = run.recording.patches[k];
      if (patch.lidar == 3 && static_cast<std::size_t>(patch.stop) < stops) solution->use[k] = 0;
    }
  };
  leave_out(6);
  EXPECT_NEAR(judged().sensors[3].covariance(3, 3) - even, unevenness_m * unevenness_m / 2.0, 1e-9);
  leave_out(8);
  const SensorResult without = judged().sensors[3];
  EXPECT_EQ(without.status, Status::failed);
  EXPECT_FALSE(without.T_base_sensor);
  EXPECT_THAT(without.reasons, ElementsAre(HasSubstr("all stops in which it saw something were left out")));
}

TEST(CalibrateLidars, FindsLidarsWithoutAGuess) {
  LightRecording run = make_light_recording(make_courtyard(7));
  for (std::size_t i = 1; i < run.guess.size(); ++i) run.guess[i].reset();
  const CalibrationResult result = calibrated(run);
  expect_right_and_good(run, result);
  EXPECT_FALSE(result.sensors[1].guess_T_base_sensor);
}

TEST(CalibrateLidars, UnitsInTheWrongOrderAreFoundAndNamed) {
  for (const auto& [a, b] : {std::pair<std::size_t, std::size_t>{1, 3}, {1, 2}}) {
    LightRecording run = make_light_recording(make_courtyard(13));
    std::swap(run.guess[a], run.guess[b]);
    const CalibrationResult result = calibrated(run);
    for (const auto& [unit, other] : {std::pair{a, b}, std::pair{b, a}}) {
      const SensorResult& sensor = result.sensors[unit];
      EXPECT_EQ(sensor.status, Status::weak);
      EXPECT_THAT(sensor.reasons,
                  Contains(HasSubstr("stands where the rig file has " + run.rig.sensors[other].name + ",")));
      ASSERT_TRUE(sensor.T_base_sensor);
      EXPECT_LT(shift_m(run, result, unit), 0.005);
      EXPECT_LT(turn_deg(run, result, unit), 0.05);
    }
    const std::size_t in_order = 6 - a - b;
    EXPECT_EQ(result.sensors[in_order].status, Status::good);
    EXPECT_LT(shift_m(run, result, in_order), 0.005);
  }
}

TEST(CalibrateLidars, ALidarThatCannotBeFoundWithoutAGuessFailsAndSaysSo) {
  LightRecording run = make_light_recording(make_courtyard(7));
  run.guess[3].reset();
  // It looked away but once: nothing shows how it was carried round.
  for (PatchCells& patch : run.recording.patches) {
    if (patch.lidar == 3 && patch.stop > 0) patch = PatchCells{3, patch.stop, 0, {}, {}, {}, 0};
  }
  const CalibrationResult result = calibrated(run);
  EXPECT_EQ(result.sensors[3].status, Status::failed);
  EXPECT_THAT(result.sensors[3].reasons, ElementsAre(HasSubstr("initial_extrinsics")));
  EXPECT_EQ(result.sensors[1].status, Status::good);
}

TEST(CalibrateLidars, AnEarlyEndDoesNotLookSolved) {
  const LightRecording run = make_light_recording(make_courtyard(8, 8));
  LidarCalibrationOptions options;
  options.last_stage = LastStage::poses;
  for (const SensorResult& sensor : calibrated(run, options).sensors) {
    if (sensor.name == run.rig.base_sensor().name) continue;
    EXPECT_EQ(sensor.status, Status::failed);
    EXPECT_FALSE(sensor.T_base_sensor);
  }
  options.last_stage = LastStage::extrinsics;
  const CalibrationResult rough = calibrated(run, options);
  EXPECT_EQ(rough.sensors[1].status, Status::weak);
  EXPECT_LT(shift_m(run, rough, 1), 0.05);
}

TEST(CalibrateLidars, StopsWhenItIsTold) {
  const LightRecording run = make_light_recording(make_courtyard(9, 6));
  SilentReporter reporter;
  std::stop_source stop;
  stop.request_stop();
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter, stop.get_token()});
  ASSERT_FALSE(result);
  EXPECT_EQ(result.error().kind, ErrorKind::cancelled);
}

TEST(CalibrateLidars, RefusesARecordingWithoutStopsOrWithoutTheBase) {
  LightRecording run = make_light_recording(make_courtyard(10, 6));
  SilentReporter reporter;
  LidarRecording nothing = run.recording;
  nothing.stops.clear();
  nothing.patches.clear();
  nothing.R_previous_this.clear();
  const auto without_stops = calibrate_lidars(run.rig, nothing, run.guess, {}, RunContext{reporter});
  ASSERT_FALSE(without_stops);
  EXPECT_THAT(without_stops.error().message(), HasSubstr("no stop"));
  run.recording.lidar_sensors[static_cast<std::size_t>(run.rig.base)] = 77;
  const auto without_base = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{reporter});
  ASSERT_FALSE(without_base);
  EXPECT_THAT(without_base.error().message(), HasSubstr("base"));
}

}  // namespace
}  // namespace rigcal
