#include "core/pipeline/solving_base.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/pipeline/lidar_result.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"

namespace rigcal {
namespace {

// What was seen in `count` directions, about ten degrees apart.
PatchSurfels seen_in(int lidar, int count) {
  PatchSurfels out{lidar, 0, {}};
  for (int k = 0; k < count; ++k) {
    const double up = to_rad(10.0 * (k / 18));
    const double round = to_rad(20.0 * (k % 18));
    Surfel surfel;
    surfel.mean = 5.0 * Vector3d(std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up));
    out.surfels.push_back(surfel);
  }
  return out;
}

// Two stops, three LiDARs; the second saw most, the third next to nothing.
struct Known {
  StartInput input;
  std::vector<std::optional<GyroTurn>> gyro_turns;
  std::vector<PatchSurfels> patches{seen_in(0, 30), seen_in(1, 50), seen_in(2, 5)};

  Known() {
    input.stops = 2;
    input.lidars = 3;
    input.guess_T_base_sensor.resize(3);
    input.R_previous_this.resize(2);
    input.turned_rad.resize(2);
  }
  void tell_turn_by(int lidar) { gyro_turns = {std::nullopt, GyroTurn{lidar, exp_so3(Vector3d(0.0, 0.3, 0.0))}}; }
  [[nodiscard]] int chosen() const { return solving_lidar(input, gyro_turns, patches); }
};

TEST(SolvingLidar, IsTheOneThatSawMostWhicheverIsTheBase) {
  Known known;
  for (const int base : {0, 1, 2}) {
    known.input.base = base;
    EXPECT_EQ(known.chosen(), 1);
  }
}

TEST(SolvingLidar, IsTheOneWithTheGyroWhereItSawAboutAsMuch) {
  Known known;
  known.tell_turn_by(0);
  for (const int base : {0, 1, 2}) {
    known.input.base = base;
    EXPECT_EQ(known.chosen(), 0);
  }
  known.tell_turn_by(2);
  EXPECT_EQ(known.chosen(), 1);
}

TEST(SolvingLidar, AWideViewCountsMoreThanManyPoints) {
  Known known;
  for (int k = 0; k < 5; ++k) {
    for (const Surfel& s : seen_in(0, 30).surfels) known.patches[0].surfels.push_back(s);
  }
  EXPECT_EQ(known.chosen(), 1);
}

TEST(SolvingLidar, EqualsArePartedByWhatTheySaw) {
  Known known;
  known.patches[0].surfels = known.patches[1].surfels;
  known.patches[0].surfels[0].N = 30.0;
  EXPECT_EQ(known.chosen(), 0);
  std::swap(known.patches[0].lidar, known.patches[1].lidar);
  EXPECT_EQ(known.chosen(), 1);
}

TEST(SolvingLidar, IsTheBaseWhereWhatIsToldHoldsInItsFrameOnly) {
  Known known;
  known.input.base = 2;
  known.input.axis = Vector3d::UnitZ();
  EXPECT_EQ(known.chosen(), 2);
  known.input.turned_rad[1] = 0.3;  // then the axis can be found
  EXPECT_EQ(known.chosen(), 1);
  known.input.R_previous_this[1] = exp_so3(Vector3d(0.0, 0.0, 0.3));
  EXPECT_EQ(known.chosen(), 2);
  known.tell_turn_by(0);
  EXPECT_EQ(known.chosen(), 0);
  known.input.trajectory = {SE3{}, SE3{}};
  EXPECT_EQ(known.chosen(), 2);
}

TEST(SolvingLidar, HasAGuessWhereOthersHave) {
  Known known;
  known.input.guess_T_base_sensor[2] = SE3{};
  EXPECT_EQ(known.chosen(), 0);
  known.tell_turn_by(1);
  EXPECT_EQ(known.chosen(), 0);
}

TEST(SeenFrom, TakesTurnsAsTheGyroToldThem) {
  Known known;
  known.tell_turn_by(1);
  known.input.axis = Vector3d::UnitZ();
  const StartInput seen = seen_from(1, known.input, known.gyro_turns);
  EXPECT_EQ(seen.base, 1);
  EXPECT_FALSE(seen.axis);
  ASSERT_TRUE(seen.R_previous_this[1]);
  EXPECT_EQ(*seen.R_previous_this[1], known.gyro_turns[1]->R_previous_this);
  EXPECT_TRUE(seen.turns_are_own);
  EXPECT_FALSE(seen_from(0, known.input, known.gyro_turns).turns_are_own);
  EXPECT_FALSE(seen.guess_T_base_sensor[0]);
}

TEST(SeenFrom, TakesTurnsByTheGuessOrElseTheirAnglesOnly) {
  Known known;
  known.input.R_previous_this[1] = exp_so3(Vector3d(0.0, 0.0, 0.3));
  known.input.guess_T_base_sensor[1] = SE3{exp_so3(Vector3d(0.5, 0.0, 0.0)), Vector3d(1.0, 0.0, 0.0)};
  known.input.guess_T_base_sensor[2] = SE3{Matrix3d::Identity(), Vector3d(0.0, 2.0, 0.0)};
  const StartInput seen = seen_from(1, known.input, {});
  const Vector3d axis = exp_so3(Vector3d(-0.5, 0.0, 0.0)) * Vector3d::UnitZ();
  ASSERT_TRUE(seen.R_previous_this[1]);
  EXPECT_LT(rotation_distance(*seen.R_previous_this[1], exp_so3(0.3 * axis)), 1e-12);
  EXPECT_FALSE(seen.turns_are_own);
  ASSERT_TRUE(seen.guess_T_base_sensor[0] && seen.guess_T_base_sensor[2]);
  EXPECT_LT((seen.guess_T_base_sensor[0]->t - Vector3d(-1.0, 0.0, 0.0)).norm(), 1e-12);
  EXPECT_LT((*seen.guess_T_base_sensor[1] * SE3{}).t.norm(), 1e-12);

  known.input.guess_T_base_sensor.assign(3, std::nullopt);
  const StartInput without = seen_from(1, known.input, {});
  EXPECT_FALSE(without.R_previous_this[1]);
  ASSERT_TRUE(without.turned_rad[1]);
  EXPECT_NEAR(*without.turned_rad[1], 0.3, 1e-12);
}

TEST(WithSigns, ATurnBackHasTheOtherSignWhicheverGyroTellsIt) {
  const auto turn = [](double rad) { return exp_so3(rad * Vector3d(0.0, -0.6, 0.8)); };
  const std::vector<std::optional<GyroTurn>> told{std::nullopt, GyroTurn{1, turn(0.5)}, GyroTurn{1, turn(0.5)},
                                                  GyroTurn{1, turn(-0.9)}, std::nullopt};
  const auto turned = with_signs({std::nullopt, 0.5, 0.5, 0.9, 0.4}, told);
  EXPECT_FALSE(turned[0]);
  EXPECT_NEAR(*turned[1], 0.5, 1e-12);
  EXPECT_NEAR(*turned[3], -0.9, 1e-12);
  EXPECT_NEAR(*turned[4], 0.4, 1e-12) << "as it was";
}

// The same run as it is told by who calls another LiDAR the base: the gyro is the first one's, its turns in the base's
// axes hang on the guess.
LightRecording named(const LightRecording& run, std::size_t base) {
  LightRecording out = run;
  out.rig.base = static_cast<int>(base);
  out.recording.gyro_turns.resize(run.recording.R_previous_this.size());
  for (std::size_t j = 0; j < run.recording.R_previous_this.size(); ++j) {
    std::optional<Matrix3d>& R = out.recording.R_previous_this[j];
    if (!R) continue;
    out.recording.gyro_turns[j] = GyroTurn{0, *R};
    if (base == 0) continue;
    if (run.guess[base]) {
      R = Matrix3d(run.guess[base]->R.transpose() * *R * run.guess[base]->R);
    } else {
      R.reset();
    }
  }
  for (std::size_t i = 0; i < out.guess.size(); ++i) {
    if (out.guess[i] && run.guess[base]) out.guess[i] = run.guess[base]->inverse() * *run.guess[i];
    if (!run.guess[base]) out.guess[i].reset();
  }
  out.guess[base] = SE3{};
  return out;
}

// tests/apps/experiment/base_experiment_test.cpp tries all bases, from guesses.
void expect_the_same_for_another_base(const LightRecording& run) {
  SilentReporter silent;
  std::optional<CalibrationResult> first;
  for (const std::size_t base : {0U, 2U}) {
    const LightRecording seen = named(run, base);
    const auto result = calibrate_lidars(seen.rig, seen.recording, seen.guess, {}, RunContext{silent});
    ASSERT_TRUE(result) << result.error().message();
    for (const SensorResult& sensor : result->sensors) ASSERT_TRUE(sensor.T_base_sensor) << sensor.reasons.front();
    EXPECT_EQ(result->sensors[base].T_base_sensor->t, Vector3d::Zero());
    EXPECT_EQ(result->trajectory[0].T_G_base.t, Vector3d::Zero());
    if (!first) {
      first = *result;
      continue;
    }
    const SE3 T_base_first = first->sensors[base].T_base_sensor->inverse();
    for (std::size_t i = 0; i < run.guess.size(); ++i) {
      const SE3 expected = T_base_first * *first->sensors[i].T_base_sensor;
      EXPECT_LT((result->sensors[i].T_base_sensor->t - expected.t).norm(), 1e-6) << base << " " << i;
      EXPECT_LT(rotation_distance(result->sensors[i].T_base_sensor->R, expected.R), 1e-7) << base << " " << i;
    }
    // T_first_base and T_base_first err by the same, each in its own frame.
    const Matrix6d A = first->sensors[base].T_base_sensor->adjoint();
    const Matrix6d expected = A * first->sensors[base].covariance * A.transpose();
    EXPECT_LT((result->sensors[0].covariance - expected).norm(), 1e-5 * expected.norm()) << base;
    // The rig went the same way.
    const SE3 T_first_base = *first->sensors[base].T_base_sensor;
    const SE3 last = T_base_first * first->trajectory.back().T_G_base * T_first_base;
    EXPECT_LT((result->trajectory.back().T_G_base.t - last.t).norm(), 1e-6);
  }
}

// Where a plane and the grid are, seen from a stop, does not depend on which stop the world begins at.
TEST(BeginAtFirstStop, MovesAllThatIsToldInTheWorld) {
  const SE3 T_G_second{exp_so3(Vector3d(0.1, -0.2, 0.7)), Vector3d(0.4, 0.1, -0.3)};
  LidarSolution solution(2, 1);
  solution.T_grid_G = {exp_so3(Vector3d(0.0, 0.3, 0.2)), Vector3d(1.0, 2.0, 3.0)};
  solution.start.stop_known = {0, 1};
  solution.state.T_G_base = {SE3{}, T_G_second};
  solution.start.state.T_G_base = solution.state.T_G_base;
  PlaneFeature plane;
  plane.center_G = Vector3d(5.0, -1.0, 0.5);
  plane.normal_G = Vector3d(0.6, 0.0, 0.8);
  solution.refined.map.features = {plane};
  const SE3 T_grid_second = solution.T_grid_G * T_G_second;
  begin_at_first_stop(solution);
  EXPECT_EQ(solution.state.T_G_base[1].R, Matrix3d::Identity());
  EXPECT_EQ(solution.state.T_G_base[1].t, Vector3d::Zero());
  const PlaneFeature& moved = solution.refined.map.features[0];
  EXPECT_LT((moved.center_G - T_G_second.inverse() * plane.center_G).norm(), 1e-12);
  EXPECT_LT((moved.normal_G - T_G_second.R.transpose() * plane.normal_G).norm(), 1e-12);
  EXPECT_LT((solution.T_grid_G.matrix() - T_grid_second.matrix()).norm(), 1e-12);
}

LightRecording courtyard() {
  sim::LightRigOptions options;
  options.seed = 7;
  options.turntable.stops = 12;
  options.shots_per_patch = 20000;
  return make_light_recording(*sim::make_light_rig(*sim::load_scene("courtyard"), options));
}

TEST(CalibrateLidars, AnyBaseGivesTheSameWithoutAGuess) {
  LightRecording run = courtyard();
  for (std::size_t i = 1; i < run.guess.size(); ++i) run.guess[i].reset();
  expect_the_same_for_another_base(run);
}

// Also the one in whose frame all is solved, which has no guess there.
TEST(CalibrateLidars, AllAreComparedWithTheirGuessOfTheBase) {
  const LightRecording run = named(courtyard(), 2);
  SilentReporter silent;
  const auto result = calibrate_lidars(run.rig, run.recording, run.guess, {}, RunContext{silent});
  ASSERT_TRUE(result) << result.error().message();
  for (std::size_t i = 0; i < run.guess.size(); ++i) {
    if (i == 2) continue;
    EXPECT_GT(result->sensors[i].hold_out.start_rms, 5.0 * result->sensors[i].hold_out.rms) << i;
  }
}

TEST(CalibrateLidars, AnyBaseGivesTheSameWithNothingKnown) {
  LightRecording run = courtyard();
  for (std::size_t i = 1; i < run.guess.size(); ++i) run.guess[i].reset();
  run.recording.R_previous_this.clear();
  expect_the_same_for_another_base(run);
}

}  // namespace
}  // namespace rigcal
