// `rigcal calibrate --method planes` on patches of simulated corners.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/extrinsics_file.h"
#include "core/io/pcd_file.h"
#include "simdata/targets/corner_clouds.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class CalibratePlanes : public testing::Test {
 protected:
  void SetUp() override {
    scratch_ = scratch_folder("planes");
    std::ofstream(scratch_ / "rig.yaml")
        << "rigcal: 1\nbase: front\nsensors:\n  front: {type: lidar}\n  side: {type: lidar}\n";
  }

  void write(const std::string& sensor, const std::vector<Vector3d>& points) const {
    fs::create_directories(scratch_ / "patches" / sensor);
    std::vector<Point> narrow;
    for (const Vector3d& p : points) {
      Point& point = narrow.emplace_back();
      point.x = static_cast<float>(p.x());
      point.y = static_cast<float>(p.y());
      point.z = static_cast<float>(p.z());
    }
    ASSERT_TRUE(write_pcd((scratch_ / "patches" / sensor / "0.pcd").string(), narrow));
  }

  [[nodiscard]] ProgramRun run(const std::string& more = {}) const {
    return run_rigcal("--json calibrate patches --method planes --rig rig.yaml --out result " + more, scratch_);
  }

  const SE3 truth_ = sim::paper_configuration(1);
  const sim::CornerClouds clouds_ =
      sim::make_corner_clouds({.angle_deg = 75.0, .sigma_m = 0.01, .stray_points = 500, .T_a_b = truth_});
  fs::path scratch_;
};

TEST_F(CalibratePlanes, WritesTheResultOfOneMoment) {
  write("front", clouds_.a.points);
  write("side", clouds_.b.points);
  const ProgramRun done = run();
  EXPECT_EQ(done.code, 0) << done.err;
  EXPECT_TRUE(fits_schema("calibrate.json", parse_json(done.out)));
  const auto written = load_extrinsics((scratch_ / "result" / "extrinsics.yaml").string());
  ASSERT_TRUE(written);
  EXPECT_EQ(written->method, "planes");
  EXPECT_THAT(written->T_base_sensor.at("side"), SE3Near(truth_, 0.03, 3.0));
  EXPECT_TRUE(fs::exists(scratch_ / "result" / "report.html"));
  EXPECT_GT(fs::file_size(scratch_ / "result" / "map.ply"), 10000U);
}

TEST_F(CalibratePlanes, EndsWithOneAndTheReasonWhereThereIsNoCorner) {
  write("front", clouds_.a.points);
  std::vector<Vector3d> walls;
  for (std::size_t k = 0; k < clouds_.b.points.size(); ++k) {
    if (clouds_.b.plane[k] == 0 || clouds_.b.plane[k] == 1) walls.push_back(clouds_.b.points[k]);
  }
  write("side", walls);
  const ProgramRun done = run();
  EXPECT_EQ(done.code, 1) << done.err;
  EXPECT_THAT(done.out, HasSubstr("only 2 of at least three planes found in what side saw"));
  const auto written = load_extrinsics((scratch_ / "result" / "extrinsics.yaml").string());
  ASSERT_TRUE(written);
  EXPECT_EQ(written->T_base_sensor.count("side"), 0U);
}

TEST_F(CalibratePlanes, RefusesWhatTheMethodDoesNotKnow) {
  write("front", clouds_.a.points);
  for (const char* option : {"--stages joint", "--images .", "--refine-intrinsics", "--pose-prior 0.1,1"}) {
    const ProgramRun refused = run(option);
    EXPECT_EQ(refused.code, 2) << option;
    EXPECT_THAT(refused.err, HasSubstr("is of no use with --method planes"));
  }
  EXPECT_FALSE(fs::exists(scratch_ / "result"));
}

TEST_F(CalibratePlanes, HaveTheirExperimentBesideThePapersFigures) {
  const ProgramRun done =
      run_rigcal("--json experiment planes --trials 1 --mountings 2 --places 1 --out tables", scratch_);
  EXPECT_EQ(done.code, 0) << done.err;
  const auto json = parse_json(done.out);
  EXPECT_TRUE(fits_schema("experiment_planes.json", json));
  ASSERT_EQ(json["table"].size(), 28U);
  for (const auto& row : json["table"]) {
    if (row["noise"] != "shared") continue;
    EXPECT_LT(row["planes"]["rotation_rad"], 1e-4);
    EXPECT_LT(row["planes"]["translation_m"], 1e-3);
  }
  EXPECT_EQ(json["mountings"]["wrong_good"], 0);
  for (const char* file : {"table.txt", "table.json", "before.svg", "after.svg"}) {
    EXPECT_TRUE(fs::exists(scratch_ / "tables" / file)) << file;
  }
  EXPECT_EQ(run_rigcal("experiment turntables", scratch_).code, 2);
}

}  // namespace
}  // namespace rigcal
