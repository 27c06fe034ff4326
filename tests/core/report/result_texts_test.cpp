#include "core/report/result_texts.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <limits>

#include "core/io/extrinsics_file.h"
#include "tests/support/json.h"
#include "tests/support/make_result.h"
#include "tests/support/schema_check.h"
#include "tests/support/yaml_json.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::Not;

TEST(ExtrinsicsYaml, IsLaidOutAsTheContractSays) {
  CalibrationResult result = make_result();
  result.sensors[1].name = "left";
  result.sensors[1].T_base_sensor = SE3{exp_so3({0.0, 0.0, pi / 2.0}), {0.5, 0.25, 2.0}};
  result.sensors[1].T_base_sensor->R << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  result.sensors[1].covariance = Matrix6d::Identity() * 0.25;
  const std::string text = extrinsics_yaml(result);
  EXPECT_THAT(text, testing::StartsWith("rigcal: 1\nbase: avia\nmethod: targetless\nstatus: failed\n"
                                        "convention: \"p_base = R p_sensor + t\"\n"));
  EXPECT_THAT(
      text,
      HasSubstr(
          "  left:\n"
          "    status: weak\n"
          "    reasons: [\"height is not fixed: no \\\"floor\\\" was seen\", \"one stop only\"]\n"
          "    translation: [0.5, 0.25, 2.0]\n"
          "    rotation_xyzw: [0.0, 0.0, 0.7071067811865475, 0.7071067811865476]\n"
          "    matrix: [[0.0, -1.0, 0.0, 0.5], [1.0, 0.0, 0.0, 0.25], [0.0, 0.0, 1.0, 2.0], [0.0, 0.0, 0.0, 1.0]]\n"
          "    matrix_inverse: [[0.0, 1.0, 0.0, -0.25], [-1.0, 0.0, 0.0, 0.5], [0.0, 0.0, 1.0, -2.0], "
          "[0.0, 0.0, 0.0, 1.0]]\n"
          "    example: {p_sensor: [1, 0, 0], p_base: [0.5, 1.25, 2.0]}\n"
          "    stddev: {translation_m: [0.5, 0.5, 0.5], rotation_deg: [28.647889756541"));
  EXPECT_THAT(text, HasSubstr("    covariance: [[0.25, 0.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.25"));
}

TEST(ExtrinsicsYaml, SaysWhichDirectionsAreWeakAndWhichWereNotFitted) {
  CalibrationResult result = make_result();
  result.sensors[1].weak_directions = {{false, Vector3d::UnitZ(), 0.25, false, true, "a level surface"}};
  result.sensors[2].weak_directions = {{true, Vector3d::UnitX(), pi / 4.0, true, false, "an upright one"}};
  const std::string text = extrinsics_yaml(result);
  EXPECT_THAT(text, HasSubstr("    weak_directions:\n"
                              "      - {of: place, axis: [0.0, 0.0, 1.0], bound_m: 0.25, open: false, frozen: true, "
                              "missing: \"a level surface\"}\n"));
  EXPECT_THAT(text, HasSubstr("      - {of: turn, axis: [1.0, 0.0, 0.0], bound_deg: 45.0, open: true, frozen: false, "
                              "missing: \"an upright one\"}\n"));
  const auto tree = parse_yaml(text, "extrinsics.yaml");
  ASSERT_TRUE(tree) << tree.error().message();
  EXPECT_TRUE(fits_schema("extrinsics.json", json_of(*tree)));
  EXPECT_TRUE(parse_extrinsics(text, "extrinsics.yaml"));
  const nlohmann::json report = parse_json(report_json(result));
  EXPECT_TRUE(fits_schema("report.json", report));
  EXPECT_EQ(report["sensors"][1]["weak_directions"][0]["bound_m"], 0.25);
  EXPECT_FALSE(report["sensors"][0].contains("weak_directions"));
}

TEST(ExtrinsicsYaml, LeavesTheKeysOfAFailedSensorsTransformOut) {
  const std::string text = extrinsics_yaml(make_result());
  EXPECT_THAT(text, testing::EndsWith("  mid40_right:\n    status: failed\n"
                                      "    reasons: [\"no stop connects it with the base\"]\n"));
}

TEST(ExtrinsicsYaml, FitsItsSchema) {
  const SchemaCheck schema("extrinsics.json");
  const auto tree = parse_yaml(extrinsics_yaml(make_result()), "extrinsics.yaml");
  ASSERT_TRUE(tree) << tree.error().message();
  nlohmann::json json = json_of(*tree);
  EXPECT_THAT(schema.violations(json), testing::IsEmpty());
  json["sensors"]["mid40_right"]["translation"] = {0.0, 0.0};
  json.erase("convention");
  EXPECT_EQ(schema.violations(json).size(), 2U);
}

TEST(TrajectoryTum, GivesTheMiddleOfEachKnownStopToTheNanosecond) {
  const std::string text = trajectory_tum(make_result());
  EXPECT_THAT(text, HasSubstr("\n1700000001.000000000 0.0 0.0 0.0 0.0 0.0 0.0 1.0\n1700000007.000000000 "));
  EXPECT_THAT(text, Not(HasSubstr("1700000004")));
}

TEST(TrajectoryTum, NumbersTheStopsWhereTheInputHadNoTimes) {
  CalibrationResult result = make_result();
  for (StopPose& pose : result.trajectory) pose.stop.start_ns = pose.stop.end_ns = 0;
  EXPECT_THAT(trajectory_tum(result), HasSubstr("\n0 0.0 0.0 0.0 0.0 0.0 0.0 1.0\n2 "));
}

TEST(ReportJson, HoldsStagesWarningsAndTheStatusOfEverySensor) {
  const auto json = parse_json(report_json(make_result()));
  EXPECT_EQ(json["rigcal"], 1);
  EXPECT_EQ(json["status"], "failed");
  EXPECT_EQ(json["stops"]["found"], 3);
  EXPECT_EQ(json["stops"]["solved"], 2);
  EXPECT_EQ(json["stages"][0]["counts"]["planes"], 9000.0);
  EXPECT_EQ(json["stages"][0]["cost_after"], 3.0);
  EXPECT_EQ(json["peak_memory_mb"], 120.5);
  EXPECT_EQ(json["warnings"][0], "a packet is damaged");
  EXPECT_NEAR(json["sensors"][1]["stddev_translation_mm"][2], 3.0, 1e-12);  // rounding of a square root
  EXPECT_FALSE(json["sensors"][2].contains("stddev_translation_mm"));
}

TEST(ReportJson, FitsItsSchema) {
  const SchemaCheck schema("report.json");
  auto json = parse_json(report_json(make_result()));
  EXPECT_THAT(schema.violations(json), testing::IsEmpty());
  // The check itself finds what does not fit.
  json["stages"][0].erase("wall_s");
  json["sensors"][0]["status"] = "fine";
  json["extra"] = 1;
  EXPECT_EQ(schema.violations(json).size(), 3U);
}

TEST(ReportJson, SurvivesAWarningThatIsNotUtf8) {
  CalibrationResult result = make_result();
  result.warnings = {"cannot read \xff\xfe"};
  EXPECT_TRUE(nlohmann::json::accept(report_json(result)));
}

TEST(CheckResult, RefusesWhatMustNotReachAFile) {
  EXPECT_TRUE(check_result(make_result()));
  CalibrationResult nan = make_result();
  nan.sensors[1].T_base_sensor->t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(check_result(nan));
  CalibrationResult failed_with_transform = make_result();
  failed_with_transform.sensors[2].T_base_sensor = SE3{};
  EXPECT_FALSE(check_result(failed_with_transform));
  CalibrationResult negative_variance = make_result();
  negative_variance.sensors[1].covariance(3, 3) = -1.0;
  EXPECT_FALSE(check_result(negative_variance));
  CalibrationResult pose = make_result();
  pose.trajectory[2].T_G_base.t.z() = std::numeric_limits<double>::infinity();
  EXPECT_FALSE(check_result(pose));
  CalibrationResult no_base = make_result();
  no_base.base = "other";
  EXPECT_FALSE(check_result(no_base));
}

}  // namespace
}  // namespace rigcal
