#include "apps/evaluation/evaluation.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "apps/common/tolerance.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::ElementsAre;

SE3 pose(double rx, double ry, double rz, double x, double y, double z) {
  Vector6d xi;
  xi << rx, ry, rz, x, y, z;
  return SE3::exp(xi);
}

// Three sensors seen from base a; b and c lie anywhere.
KnownRig rig_with_base_a() {
  KnownRig rig;
  rig.base = "a";
  rig.sensors = {{"a", Status::good, SE3{}, {}},
                 {"b", Status::good, pose(0.1, 0.2, 1.0, 0.3, -0.2, 0.1), {}},
                 {"c", Status::good, pose(-0.4, 0.1, 2.0, -0.1, 0.4, 0.2), {}}};
  for (int j = 0; j < 4; ++j) {
    rig.poses.push_back({j, j * 10 + 1, j * 10 + 9, pose(0.0, 0.02 * j, 0.5 * j, 0.1 * j, 0.0, 0.0)});
  }
  return rig;
}

// The same rig as it looks from base b.
KnownRig rig_with_base_b() {
  KnownRig rig = rig_with_base_a();
  const SE3 T_a_b = *rig.sensors[1].T_base_sensor;
  rig.base = "b";
  for (auto& sensor : rig.sensors) sensor.T_base_sensor = T_a_b.inverse() * *sensor.T_base_sensor;
  for (auto& stop : rig.poses) stop.T_G_base = T_a_b.inverse() * stop.T_G_base * T_a_b;
  return rig;
}

TEST(Evaluation, FindsNoErrorInTheTruthItselfAlsoFromAnotherBase) {
  const Expected<Evaluation> evaluation = evaluate(rig_with_base_b(), rig_with_base_a());
  ASSERT_TRUE(evaluation);
  ASSERT_EQ(evaluation->sensors.size(), 2U);
  for (const SensorError& error : evaluation->sensors) {
    EXPECT_TRUE(error.compared);
    EXPECT_LT(error.rotation_rad, 1e-7);  // the angle of a product of rotations is known to the root of the rounding
    EXPECT_LT(error.translation_m, 1e-12);
  }
  ASSERT_TRUE(evaluation->poses);
  EXPECT_EQ(evaluation->poses->compared, 4);
  EXPECT_LT(evaluation->poses->worst_rotation_rad, 1e-7);
  EXPECT_LT(evaluation->poses->worst_translation_m, 1e-12);
}

TEST(Evaluation, MeasuresAnErrorAlongTheSensorsOwnAxes) {
  KnownRig result = rig_with_base_a();
  const SE3 truth = *result.sensors[1].T_base_sensor;
  result.sensors[1].T_base_sensor = truth * pose(0.0, 0.0, 0.002, 0.003, 0.0, 0.0);
  result.sensors[1].covariance = Matrix6d::Identity() * 1e-6;
  const Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  ASSERT_TRUE(evaluation);
  const SensorError& error = evaluation->sensors[0];
  EXPECT_NEAR(error.rotation_rad, 0.002, 1e-9);
  EXPECT_NEAR(error.translation_m, 0.003, 1e-8);  // the turn bends the way by a millionth of its length
  EXPECT_NEAR(error.xi[2], 0.002, 1e-12);
  EXPECT_NEAR(error.xi[3], 0.003, 1e-12);
  EXPECT_NEAR(*error.nees_per_dof, (4.0 + 9.0) / 6.0, 1e-8);
}

TEST(Evaluation, NamesFailedMissingAndUnknownSensors) {
  KnownRig result = rig_with_base_a();
  result.sensors[1].status = Status::failed;
  result.sensors[1].T_base_sensor.reset();
  result.sensors[2].name = "d";
  const Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  ASSERT_TRUE(evaluation);
  ASSERT_EQ(evaluation->sensors.size(), 2U);
  EXPECT_EQ(evaluation->sensors[0].name, "b");
  EXPECT_FALSE(evaluation->sensors[0].compared);
  EXPECT_EQ(evaluation->sensors[1].name, "c");
  EXPECT_TRUE(evaluation->sensors[1].missing);
  EXPECT_THAT(evaluation->not_in_truth, ElementsAre("d"));
  EXPECT_FALSE(is_within(*evaluation, 1.0, 1.0));
}

TEST(Evaluation, GivesNoNeesForACovarianceThatIsNotRegular) {
  KnownRig result = rig_with_base_a();
  result.sensors[1].covariance = Matrix6d::Zero();
  EXPECT_FALSE(evaluate(result, rig_with_base_a())->sensors[0].nees_per_dof);
}

TEST(Evaluation, RefusesATruthOfAnotherRig) {
  KnownRig other = rig_with_base_a();
  other.base = "x";
  for (auto& sensor : other.sensors) sensor.name = "x" + sensor.name;
  EXPECT_FALSE(evaluate(rig_with_base_a(), other));
  other.sensors.push_back({"a", Status::good, SE3{}, {}});
  other.poses.clear();
  EXPECT_FALSE(evaluate(rig_with_base_a(), other));
}

TEST(Evaluation, OfTheBaseAloneComparesItsPoses) {
  KnownRig result = rig_with_base_a();
  result.sensors.resize(1);
  Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  ASSERT_TRUE(evaluation) << evaluation.error().message();
  EXPECT_FALSE(has_sensors(*evaluation));
  EXPECT_EQ(evaluation->poses->compared, 4);
  result.poses.resize(1);
  EXPECT_FALSE(evaluate(result, rig_with_base_a())) << "one pose is compared with nothing";
}

TEST(Evaluation, ComparesPosesFromTheFirstCommonStopOn) {
  KnownRig result = rig_with_base_a();
  result.poses.erase(result.poses.begin());
  const SE3 T_second_G = result.poses.front().T_G_base.inverse();
  for (auto& stop : result.poses) {
    stop.start_ns = stop.end_ns = stop.start_ns + 4;
    stop.stop.reset();
    stop.T_G_base = T_second_G * stop.T_G_base;
  }
  result.poses.back().T_G_base.t.x() += 0.005;
  const Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  ASSERT_TRUE(evaluation && evaluation->poses);
  EXPECT_EQ(evaluation->poses->compared, 3);
  EXPECT_EQ(evaluation->poses->unmatched, 1);
  EXPECT_NEAR(evaluation->poses->worst_translation_m, 0.005, 1e-12);
  EXPECT_NEAR(evaluation->poses->median_translation_m, 0.0025, 1e-12);
}

TEST(Evaluation, FindsAStopByItsNumberWhereTheResultHasNoTimes) {
  KnownRig result = rig_with_base_a();
  for (auto& stop : result.poses) stop.start_ns = stop.end_ns = 0;
  result.poses.erase(result.poses.begin() + 1);
  const Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  ASSERT_TRUE(evaluation && evaluation->poses);
  EXPECT_EQ(evaluation->poses->compared, 3);
  EXPECT_LT(evaluation->poses->worst_translation_m, 1e-12);
}

TEST(Evaluation, IsWithinBoundsOnlyWhenBothAreKept) {
  KnownRig result = rig_with_base_a();
  result.sensors[1].T_base_sensor = *result.sensors[1].T_base_sensor * pose(0.0, 0.0, 0.002, 0.003, 0.0, 0.0);
  const Expected<Evaluation> evaluation = evaluate(result, rig_with_base_a());
  EXPECT_TRUE(is_within(*evaluation, 0.0031, 0.0021));
  EXPECT_FALSE(is_within(*evaluation, 0.0029, 0.0021));
  EXPECT_FALSE(is_within(*evaluation, 0.0031, 0.0019));
}

TEST(Evaluation, CountsAFailedSensorAgainstTheBoundsButNotOneThatTheResultDoesNotName) {
  KnownRig result = rig_with_base_a();
  result.sensors.pop_back();
  EXPECT_TRUE(is_within(*evaluate(result, rig_with_base_a()), 0.001, 0.001));
  result.sensors.push_back({"c", Status::failed, std::nullopt, std::nullopt});
  EXPECT_FALSE(is_within(*evaluate(result, rig_with_base_a()), 0.001, 0.001));
}

TEST(Tolerance, ReadsALengthAndAnAngleWithTheirUnits) {
  EXPECT_DOUBLE_EQ(parse_tolerance("10mm,0.1deg")->translation_m, 0.01);
  EXPECT_DOUBLE_EQ(parse_tolerance("10mm,0.1deg")->rotation_rad, to_rad(0.1));
  EXPECT_DOUBLE_EQ(parse_tolerance("1.5cm, 2e-3rad")->translation_m, 0.015);
  EXPECT_DOUBLE_EQ(parse_tolerance("1.5cm, 2e-3rad")->rotation_rad, 0.002);
}

TEST(Tolerance, OfADistanceMayBeZero) {
  ASSERT_TRUE(parse_distance("0mm,0deg"));
  EXPECT_EQ(parse_distance("0mm,0deg")->translation_m, 0.0);
  EXPECT_DOUBLE_EQ(parse_distance("0mm,5deg")->rotation_rad, to_rad(5.0));
  for (const char* text : {"", "0,0", "-1mm,1deg", "-0mm,1deg", "nanmm,1deg"})
    EXPECT_FALSE(parse_distance(text)) << text;
}

TEST(Tolerance, RefusesWhatIsNotABound) {
  for (const char* text :
       {"", "10mm", "10,0.1", "0.1deg,10mm", "-1mm,1deg", "0mm,1deg", "nanmm,1deg", "1mm,1deg,", "1mm,infdeg"}) {
    EXPECT_FALSE(parse_tolerance(text)) << text;
    EXPECT_FALSE(check_tolerance(text).empty()) << text;
  }
}

}  // namespace
}  // namespace rigcal
