#include "core/pipeline/incremental_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

sim::LightRig courtyard(int stops, int shots = 20000) {
  sim::LightRigOptions options;
  options.seed = 3;
  options.turntable.stops = stops;
  options.shots_per_patch = shots;
  return *sim::make_light_rig(*sim::load_scene("courtyard"), options);
}

IncrementalCalibration begin(const LightRecording& run, const Requirement& goal = {}) {
  IncrementalOptions options;
  options.goal = goal;
  return {run.rig, run.recording.lidar_sensors, run.guess, options};
}

std::vector<StopEstimate> all_estimates(IncrementalCalibration& calibration, const LightRecording& run) {
  SilentReporter silent;
  std::vector<StopEstimate> out;
  for (CalibrationStop& stop : stops_of(run.recording)) {
    calibration.add_stop(std::move(stop));
    auto estimate = calibration.estimate({silent});
    EXPECT_TRUE(estimate) << estimate.error().message();
    if (!estimate) break;
    out.push_back(std::move(*estimate));
  }
  return out;
}

bool are_same(const SE3& a, const SE3& b) { return a.R == b.R && a.t == b.t; }

std::string reasons(const StopEstimate& estimate) {
  std::string text;
  for (const LidarEstimate& lidar : estimate.lidars) {
    for (const std::string& reason : lidar.result.reasons) text += lidar.result.name + ": " + reason + "\n";
  }
  return text;
}

TEST(StopsOf, KeepWhatWasTooFar) {
  LidarRecording recording;
  recording.lidar_sensors = {0, 1};
  recording.stops.resize(2);
  recording.too_far = {{0, 0}, {0, 70}};
  LidarRecording again;
  again.lidar_sensors = recording.lidar_sensors;
  std::vector<CalibrationStop> stops = stops_of(recording);
  append(std::move(stops[0]), again);
  EXPECT_FALSE(again.saw_too_far(1));
  append(std::move(stops[1]), again);
  EXPECT_EQ(again.too_far, recording.too_far);
  EXPECT_TRUE(again.saw_too_far(1));
  EXPECT_TRUE(stops_of(LidarRecording{}).empty());
}

TEST(IncrementalCalibration, TellsAfterEachStopWhatIsKnownAndEndsAsTheBatch) {
  const LightRecording run = make_light_recording(courtyard(8, 10000));
  IncrementalCalibration calibration = begin(run, {0.005, to_rad(0.05)});
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 8U);
  int from_before = 0;
  for (std::size_t j = 0; j < estimates.size(); ++j) {
    EXPECT_EQ(estimates[j].stops, static_cast<int>(j) + 1);
    EXPECT_EQ(estimates[j].lidars.size(), run.rig.sensors.size());
    from_before += estimates[j].searched ? 0 : 1;
  }
  EXPECT_GE(from_before, 3);
  // One stop shares nothing between LiDARs that look opposite ways; all of them share everything.
  EXPECT_FALSE(estimates.front().reached);
  const StopEstimate& last = estimates.back();
  EXPECT_TRUE(last.reached) << reasons(last);
  for (std::size_t i = 1; i < last.lidars.size(); ++i) {
    const LidarEstimate& lidar = last.lidars[i];
    ASSERT_TRUE(lidar.result.T_base_sensor);
    EXPECT_LT((lidar.result.T_base_sensor->t - run.truth.T_base_sensor[i].t).norm(), 0.005);
    EXPECT_LT(rotation_distance(lidar.result.T_base_sensor->R, run.truth.T_base_sensor[i].R), to_rad(0.05));
    EXPECT_LT(lidar.translation_bound_m, 0.005);
    EXPECT_NEAR(lidar.weak_translation.norm(), 1.0, 1e-9);
  }
  EXPECT_TRUE(last.advice);
  EXPECT_FALSE(last.advice_text.empty());

  // All stops at once give the same, to the bit.
  SilentReporter silent;
  const auto at_once = calibrate_lidars(run.rig, run.recording, run.guess, {}, {silent});
  const auto stepwise = calibration.finish({}, std::nullopt, {silent});
  ASSERT_TRUE(at_once);
  ASSERT_TRUE(stepwise);
  ASSERT_EQ(stepwise->sensors.size(), at_once->sensors.size());
  for (std::size_t i = 0; i < at_once->sensors.size(); ++i) {
    EXPECT_EQ(stepwise->sensors[i].status, at_once->sensors[i].status);
    EXPECT_TRUE(are_same(*stepwise->sensors[i].T_base_sensor, *at_once->sensors[i].T_base_sensor));
    EXPECT_TRUE(stepwise->sensors[i].covariance == at_once->sensors[i].covariance);
  }
  for (std::size_t j = 0; j < at_once->trajectory.size(); ++j) {
    EXPECT_TRUE(are_same(stepwise->trajectory[j].T_G_base, at_once->trajectory[j].T_G_base));
  }
  EXPECT_EQ(stepwise->map.size(), at_once->map.size());
}

TEST(IncrementalCalibration, SearchesAnewWhereNeitherTurnsNorAxisAreKnown) {
  LightRecording run = make_light_recording(courtyard(5, 10000));
  for (auto& R : run.recording.R_previous_this) R.reset();
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 5U);
  for (const StopEstimate& estimate : estimates) EXPECT_TRUE(estimate.searched);
}

// Six of 24 stops of an AVIA and a MID-40 that look the same way, so that both are found from the first one on; as
// a gyro on the base told their turns.
LightRecording part_of_turn() {
  static const sim::LightRig light = [] {
    Rig rig = sim::nominal_rig();
    rig.sensors.resize(2);
    rig.sensors[1].initial_T_base_sensor = pose_deg(0.0, 0.0, 15.0, 0.0, 0.1, 0.0);
    sim::LightRigOptions options;
    options.seed = 3;
    options.turntable.stops = 24;
    options.shots_per_patch = 8000;
    return *sim::make_light_rig(*sim::load_scene("courtyard"), options, rig);
  }();
  LightRecording run = make_light_recording(light, {0, 1, 2, 3, 4, 5});
  run.recording.gyro_turns.resize(6);
  for (std::size_t j = 1; j < 6; ++j) {
    run.recording.gyro_turns[j] = GyroTurn{run.rig.base, *run.recording.R_previous_this[j]};
  }
  run.rig.turntable.emplace().axis = light.axis;
  return run;
}

void expect_stops_near(const IncrementalCalibration& calibration, const LightRecording& run,
                       const std::vector<char>& known) {
  ASSERT_NE(calibration.solution(), nullptr);
  EXPECT_EQ(calibration.solution()->start.stop_known, known);
  for (std::size_t j = 0; j < known.size(); ++j) {
    if (!known[j]) continue;
    const SE3& T = calibration.solution()->state.T_G_base[j];
    EXPECT_THAT(T, SE3Near(run.truth.T_G_base[j], 0.2, 15.0)) << "stop " << j;
  }
}

TEST(IncrementalCalibration, SearchesSoonerWhileSomethingFails) {
  // A third of a turn: the LiDARs look to all sides and have not seen the same yet.
  sim::LightRigOptions options;
  options.turntable.stops = 20;
  options.shots_per_patch = 5000;
  LightRecording run = make_light_recording(*sim::make_light_rig(*sim::load_scene("room"), options));
  IncrementalCalibration calibration = begin(run);
  SilentReporter silent;
  std::vector<int> searches;
  std::vector<CalibrationStop> stops = stops_of(run.recording);
  for (int j = 0; j < 6; ++j) {
    calibration.add_stop(std::move(stops[static_cast<std::size_t>(j)]));
    const auto estimate = calibration.estimate({silent});
    ASSERT_TRUE(estimate) << estimate.error().message();
    EXPECT_FALSE(estimate->lidars[1].result.T_base_sensor);
    if (estimate->searched) searches.push_back(j + 1);
  }
  EXPECT_THAT(searches, ElementsAre(1, 2, 3, 5));
}

TEST(IncrementalCalibration, GoesOnWithoutAGyroByTheTablesAxis) {
  LightRecording run = part_of_turn();
  for (auto& R : run.recording.R_previous_this) R.reset();
  run.recording.gyro_turns.clear();
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 6U);
  EXPECT_FALSE(estimates[3].searched);
  EXPECT_FALSE(estimates[4].searched);
  expect_stops_near(calibration, run, {1, 1, 1, 1, 1, 1});
}

// By a gyro on another LiDAR, whose turns nobody told in the base's frame.
TEST(IncrementalCalibration, GoesOnByAGyroThatSitsWhereItWasFound) {
  LightRecording run = part_of_turn();
  const Matrix3d R_base_gyro = run.truth.T_base_sensor[1].R;
  for (std::size_t j = 1; j < 6; ++j) {
    const Matrix3d R = *run.recording.R_previous_this[j];
    run.recording.R_previous_this[j].reset();
    run.recording.gyro_turns[j] = GyroTurn{1, R_base_gyro.transpose() * R * R_base_gyro};
  }
  run.rig.turntable.reset();
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 6U);
  EXPECT_TRUE(calibration.solution()->start.lidar_known[1]);
  EXPECT_FALSE(estimates[4].searched);
}

// What the stop did not see no search would find, and the turns lead on from the one before it.
TEST(IncrementalCalibration, GoesOnAfterAStopThatWasLeftOut) {
  LightRecording run = part_of_turn();
  std::erase_if(run.recording.patches, [](const PatchCells& patch) { return patch.stop == 3; });
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 6U);
  EXPECT_FALSE(estimates[3].searched);
  EXPECT_THAT(estimates[3].warnings, ElementsAre(HasSubstr("stop 3 is left out")));
  EXPECT_FALSE(estimates[4].searched);
  EXPECT_THAT(estimates[4].warnings, IsEmpty());
  expect_stops_near(calibration, run, {1, 1, 1, 0, 1, 1});
}

TEST(IncrementalCalibration, ChecksTheGyroWhereItGoesOn) {
  LightRecording run = part_of_turn();
  const Matrix3d wrong = exp_so3(Vector3d(0.0, 0.0, to_rad(7.0)));
  for (std::size_t j = 4; j < 5; ++j) {
    run.recording.gyro_turns[j]->R_previous_this *= wrong;
    *run.recording.R_previous_this[j] *= wrong;
  }
  run.recording.stops.pop_back();
  std::erase_if(run.recording.patches, [](const PatchCells& patch) { return patch.stop == 5; });
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 5U);
  EXPECT_FALSE(estimates[4].searched);
  EXPECT_THAT(estimates[4].warnings, ElementsAre(HasSubstr("turned otherwise than the gyro tells")));
  expect_stops_near(calibration, run, {1, 1, 1, 1, 0});
}

TEST(IncrementalCalibration, TakesAGivenTrajectory) {
  LightRecording run = make_light_recording(courtyard(5, 10000));
  run.recording.R_previous_this.clear();
  const SE3 elsewhere{exp_so3(Vector3d(0.0, 0.0, 0.4)), Vector3d(3.0, 1.0, 0.0)};
  for (const SE3& T : run.truth.T_G_base) {
    run.recording.trajectory.emplace_back(elsewhere * T * SE3::exp((Vector6d() << 0, 0, 0.004, 0.01, 0, 0).finished()));
  }
  run.recording.trajectory_is_prior = true;
  IncrementalCalibration calibration = begin(run);
  const std::vector<StopEstimate> estimates = all_estimates(calibration, run);
  ASSERT_EQ(estimates.size(), 5U);
  EXPECT_FALSE(estimates.back().searched);
  for (std::size_t i = 1; i < estimates.back().lidars.size(); ++i) {
    const auto& T = estimates.back().lidars[i].result.T_base_sensor;
    ASSERT_TRUE(T);
    EXPECT_LT((T->t - run.truth.T_base_sensor[i].t).norm(), 0.05);
  }
}

TEST(IncrementalCalibration, AStopCostsTheSameHoweverManyPointsWereSeen) {
  // Four times the points fill nearly the same cells: what is kept of them grows far less.
  const auto cells = [](int shots) {
    std::size_t count = 0;
    for (const PatchCells& patch : make_light_recording(courtyard(2, shots)).recording.patches) {
      count += patch.cells.size();
    }
    return static_cast<double>(count);
  };
  EXPECT_LT(cells(80000), 2.0 * cells(20000));
}

TEST(IncrementalCalibration, CountsWhatLiesTooFarOverAllStops) {
  LidarRecording recording;
  CalibrationStop stop;
  append(stop, recording);
  stop.too_far = {7, 0, 2};
  append(stop, recording);
  append(stop, recording);
  EXPECT_EQ(recording.too_far_of(0), 14U);
  EXPECT_EQ(recording.too_far_of(1), 0U);
  EXPECT_EQ(recording.too_far_of(2), 4U);
  EXPECT_EQ(recording.too_far_of(3), 0U);
}

TEST(IncrementalCalibration, CanBeStopped) {
  const LightRecording run = make_light_recording(courtyard(2));
  IncrementalCalibration calibration = begin(run);
  for (CalibrationStop& stop : stops_of(run.recording)) calibration.add_stop(std::move(stop));
  SilentReporter silent;
  std::stop_source source;
  source.request_stop();
  const auto estimate = calibration.estimate({silent, source.get_token()});
  ASSERT_FALSE(estimate);
  EXPECT_EQ(estimate.error().kind, ErrorKind::cancelled);
}

}  // namespace
}  // namespace rigcal
