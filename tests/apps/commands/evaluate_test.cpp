// rigcal evaluate, from files to exit code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/io/ground_truth.h"
#include "core/report/result_folder.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

class Evaluate : public testing::Test {
 protected:
  void SetUp() override {
    scratch = scratch_folder("evaluate");
    write_files();
  }

  // The truth, and a result that is 2 mm and 0.02 degrees off along the axes of mid40, with a sigma of 1 mm and 0.01
  // deg.
  void write_files() const {
    Vector6d xi;
    xi << 0.0, 0.0, 0.5, 0.1, 0.2, 0.3;
    GroundTruth truth;
    truth.base = "avia";
    truth.T_base_sensor = {{"avia", SE3{}}, {"mid40", SE3::exp(xi)}};
    Vector6d off;
    off << 0.0, 0.0, to_rad(0.02), 0.002, 0.0, 0.0;
    CalibrationResult result;
    result.base = "avia";
    result.method = "targetless";
    result.status = Status::good;
    SensorResult base{"avia", Status::good, {}, SE3{}, Matrix6d::Zero()};
    SensorResult mid40{"mid40", Status::good, {}, SE3::exp(xi) * SE3::exp(off), Matrix6d::Zero()};
    mid40.covariance.diagonal() << Vector3d::Constant(std::pow(to_rad(0.01), 2)), Vector3d::Constant(1e-6);
    result.sensors = {base, mid40};
    for (int j = 0; j < 3; ++j) {
      const Stop stop{j, 1000 + j * 100, 1090 + j * 100};
      const SE3 T_G_base{exp_so3({0.0, 0.0, 0.3 * j}), {0.0, 0.0, 0.0}};
      truth.stops.push_back({stop, T_G_base});
      result.trajectory.push_back({stop, T_G_base, true});
    }
    ASSERT_TRUE(write_ground_truth(scratch / "truth.yaml", truth));
    ASSERT_TRUE(write_result_folder(result, scratch / "result"));
  }

  [[nodiscard]] ProgramRun evaluate(const std::string& arguments) const {
    return run_rigcal("evaluate " + arguments, scratch);
  }

  std::filesystem::path scratch;
};

TEST_F(Evaluate, PrintsATableAndEndsWithZeroWhateverTheErrors) {
  const ProgramRun run = evaluate("result --truth truth.yaml");
  EXPECT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, testing::ContainsRegex("mid40 +good +0\\.0200 +2\\.00 "));
  EXPECT_THAT(run.out, HasSubstr("poses of 3 stops"));
  EXPECT_THAT(run.err, IsEmpty());
}

TEST_F(Evaluate, PrintsOneJsonObject) {
  const ProgramRun run = evaluate("result/extrinsics.yaml --truth truth.yaml --json --max-error 3mm,0.03deg");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto json = parse_json(run.out);
  EXPECT_EQ(json["command"], "evaluate");
  EXPECT_NEAR(json["sensors"][0]["translation_error_mm"], 2.0, 1e-6);  // the turn bends 2 mm by 1e-8 of it
  EXPECT_NEAR(json["sensors"][0]["nees_per_dof"], (4.0 + 4.0) / 6.0, 1e-6);
  EXPECT_EQ(json["within_max_error"], true);
  EXPECT_TRUE(fits_schema("evaluate.json", json));
  EXPECT_FALSE(json.contains("poses"));  // no folder was given, so there is no trajectory
}

TEST_F(Evaluate, PrintsThePosesInItsJsonToo) {
  const auto json = parse_json(evaluate("result --truth truth.yaml --json").out);
  EXPECT_TRUE(fits_schema("evaluate.json", json));
  EXPECT_EQ(json["poses"]["compared"], 3);
}

TEST_F(Evaluate, EndsWithOneWhenABoundIsExceeded) {
  EXPECT_EQ(evaluate("result --truth truth.yaml --max-error 1.9mm,0.03deg").code, 1);
  EXPECT_EQ(evaluate("result --truth truth.yaml --max-error 3mm,0.019deg").code, 1);
  EXPECT_EQ(evaluate("result --truth truth.yaml --max-error 3mm,0.03deg").code, 0);
}

TEST_F(Evaluate, EndsWithTwoWhenTheBoundIsNoBound) {
  const ProgramRun run = evaluate("result --truth truth.yaml --max-error 3,4");
  EXPECT_EQ(run.code, 2);
  EXPECT_THAT(run.err, HasSubstr("10mm,0.1deg"));
}

TEST_F(Evaluate, EndsWithThreeAndNamesTheFileThatIsMissingOrDamaged) {
  EXPECT_THAT(evaluate("result --truth nowhere.yaml").err, HasSubstr("nowhere.yaml"));
  EXPECT_EQ(evaluate("result --truth nowhere.yaml").code, 3);
  EXPECT_EQ(evaluate("nowhere --truth truth.yaml").code, 3);
  std::ofstream(scratch / "result" / "trajectory.tum") << "1 2 3\n";
  const ProgramRun run = evaluate("result --truth truth.yaml");
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("trajectory.tum:1"));
}

}  // namespace
}  // namespace rigcal
