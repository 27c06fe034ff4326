// `rigcal calibrate --method checkerboard`: two simulated LiDARs with rings, and real recordings.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/extrinsics_file.h"
#include "core/io/pcd_file.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/real_recordings.h"
#include "tests/support/ring_scans.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ContainsRegex;
using testing::HasSubstr;

constexpr const char* board_line =
    "board: {type: checkerboard, inner_corners: [7, 5], square: 0.095, size: [0.85, 0.61]}\n";

class CalibrateBoard : public testing::Test {
 protected:
  void write_rig(const std::string& sensors, const std::string& base, const std::string& board) const {
    std::ofstream(scratch_ / "rig.yaml") << "rigcal: 1\nbase: " << base << "\nsensors:\n" << sensors << board;
  }

  // Two LiDARs of a vehicle, half a metre apart, and a plate in `poses` poses.
  void write_two_lidars(int poses, const Eigen::Vector2d& plate) const {
    write_rig("  front: {type: lidar, rings: true}\n  side: {type: lidar}\n", "front", board_line);
    fs::create_directories(scratch_ / "poses" / "front");
    fs::create_directories(scratch_ / "poses" / "side");
    Random random(11);
    for (int k = 0; k < poses; ++k) {
      const SE3 T = plate_at(0.12 * k - 0.6, 2.0 + 0.1 * (k % 4), 0.5 + 0.07 * (k % 5), 0.35 * ((k % 3) - 1));
      const std::string file = std::to_string(k) + ".pcd";
      ASSERT_TRUE(write_pcd((scratch_ / "poses" / "front" / file).string(), ring_scan({T}, plate, 0.01, random)));
      const SE3 there = truth_.inverse() * T;
      ASSERT_TRUE(write_pcd((scratch_ / "poses" / "side" / file).string(), ring_scan({there}, plate, 0.01, random)));
    }
  }

  [[nodiscard]] ProgramRun run(const std::string& more = {}) const {
    return run_rigcal("--json calibrate poses --method checkerboard --rig rig.yaml --out result " + more, scratch_);
  }
  [[nodiscard]] ExtrinsicsFile result() const {
    const auto written = load_extrinsics((scratch_ / "result" / "extrinsics.yaml").string());
    EXPECT_TRUE(written);
    return written ? *written : ExtrinsicsFile{};
  }

  const SE3 truth_{exp_so3({0.1, -0.05, 0.4}), {0.1, 0.5, -0.1}};
  fs::path scratch_ = scratch_folder("board");
};

TEST_F(CalibrateBoard, PlacesALidarByTheBoardAlone) {
  write_two_lidars(12, {0.85, 0.61});
  const ProgramRun done = run("--require 30mm,1deg");
  EXPECT_EQ(done.code, 0) << done.err << done.out;
  EXPECT_TRUE(fits_schema("calibrate.json", parse_json(done.out)));
  EXPECT_EQ(result().method, "checkerboard");
  EXPECT_THAT(result().T_base_sensor.at("side"), SE3Near(truth_, 0.3, 15.0));
  EXPECT_TRUE(fs::exists(scratch_ / "result" / "report.html"));
}

TEST_F(CalibrateBoard, SaysWhatItSawWhereThePlateHasAnotherSize) {
  write_two_lidars(3, {1.2, 0.9});
  const ProgramRun done = run();
  EXPECT_EQ(done.code, 1) << done.err;
  EXPECT_THAT(done.out, HasSubstr("correct its size in the rig file"));
  EXPECT_EQ(result().T_base_sensor.count("side"), 0U);
}

TEST_F(CalibrateBoard, WantsABoardInTheRigFile) {
  write_two_lidars(1, {0.85, 0.61});
  write_rig("  front: {type: lidar}\n  side: {type: lidar}\n", "front", "");
  const ProgramRun refused = run();
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.err, HasSubstr("rig.yaml: the rig file has no board; add board:"));
}

TEST_F(CalibrateBoard, RefusesWhatTheMethodDoesNotKnow) {
  write_two_lidars(1, {0.85, 0.61});
  for (const char* option : {"--stages joint", "--pose-prior 0.1,1", "--full-map", "--incremental"}) {
    const ProgramRun refused = run(option);
    EXPECT_EQ(refused.code, 2) << option;
    EXPECT_THAT(refused.err, HasSubstr("is of no use with --method checkerboard"));
  }
}

TEST_F(CalibrateBoard, PlacesARealFisheyeCamera) {
  const fs::path set = real_recordings() / "board_vlp16_fisheye";
  if (!fs::exists(set)) GTEST_SKIP() << "no real recordings at " << set;
  write_rig(
      "  vlp16: {type: lidar, rings: true}\n  fisheye: {type: camera, intrinsics: {model: equidistant, width: 1920, "
      "height: 1208, fx: 1176.93, fy: 1177.72, cx: 962.275, cy: 612.725, distortion: [-0.0540096, -0.0784275, "
      "0.0959641, -0.0515253]}}\n",
      "vlp16", board_line);
  fs::create_directories(scratch_ / "poses" / "vlp16");
  fs::create_directories(scratch_ / "poses" / "image" / "fisheye");
  for (int pose = 1; pose <= 23; pose += 2) {
    const std::string number = std::to_string(pose);
    fs::create_symlink(set / "pcd" / ("pose" + number + "_full.pcd"), scratch_ / "poses" / "vlp16" / (number + ".pcd"));
    fs::create_symlink(set / "images" / ("pose" + number + ".png"),
                       scratch_ / "poses" / "image" / "fisheye" / (number + ".png"));
  }
  const ProgramRun done = run("--require 15mm,0.5deg");
  EXPECT_EQ(done.code, 0) << done.err << done.out;
  EXPECT_THAT(done.out, ContainsRegex("the ranges of vlp16 are 1[0-9.]+ mm too short by the boards"));
  const SE3 published{exp_so3({0.0, 0.0, -1.49}) * exp_so3({0.0, -0.005, 0.0}) * exp_so3({-1.70, 0.0, 0.0}),
                      {0.06, 0.0, -0.17}};
  EXPECT_THAT(result().T_base_sensor.at("fisheye"), SE3Near(published, 2.0, 50.0));
  const auto report = parse_json(text_of(scratch_ / "result/report.json"));
  EXPECT_TRUE(fits_schema("report.json", report));
  EXPECT_GE(report["stops"]["solved"], 11) << "all that hold a board";
  for (const auto& sensor : report["sensors"]) {
    EXPECT_GT(sensor["hold_out"]["over_noise"], 0.0);
    EXPECT_EQ(sensor["hold_out"]["unit"], sensor["name"] == "fisheye" ? "px" : "m");
  }
  ASSERT_EQ(report["cameras"].size(), 1U);
  const ProgramRun exported = run_rigcal("export result --format kalibr --out kalibr.yaml", scratch_);
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_THAT(text_of(scratch_ / "kalibr.yaml"), HasSubstr("cam0:"));
}

TEST_F(CalibrateBoard, FindsARealStereoPairAndItsIntrinsics) {
  const fs::path set = real_recordings() / "stereo_board";
  if (!fs::exists(set)) GTEST_SKIP() << "no real recordings at " << set;
  write_rig("  left: {type: camera}\n  right: {type: camera}\n", "left",
            "board: {type: checkerboard, inner_corners: [9, 6], square: 1}\n");
  for (const char* side : {"left", "right"}) {
    fs::create_directories(scratch_ / "poses" / "image" / side);
    for (int number = 1; number <= 14; ++number) {
      const fs::path file = set / (side + std::string(number < 10 ? "0" : "") + std::to_string(number) + ".jpg");
      if (!fs::exists(file)) continue;
      fs::create_symlink(file, scratch_ / "poses" / "image" / side / (std::to_string(number) + ".jpg"));
    }
  }
  const ProgramRun without = run();
  EXPECT_EQ(without.code, 1) << without.err;
  EXPECT_THAT(without.out, HasSubstr("--refine-intrinsics"));
  const ProgramRun done = run("--refine-intrinsics --require 100mm,1deg");
  EXPECT_EQ(done.code, 0) << done.err << done.out;
  EXPECT_TRUE(fits_schema("calibrate.json", parse_json(done.out)));
  // An independent solution (OpenCV's) has these figures, and all 13 boards hold.
  EXPECT_LT((result().T_base_sensor.at("right").inverse().t - Vector3d(-3.3267, 0.0372, -0.0032)).norm(), 0.005);
  EXPECT_THAT(text_of(scratch_ / "result/report.json"), ContainsRegex("\"boards\": ?13(\\.0)?[,}\n]"));
  EXPECT_THAT(text_of(scratch_ / "result/extrinsics.yaml"),
              HasSubstr("intrinsics: {model: radtan, width: 640, height: 480"));
}

}  // namespace
}  // namespace rigcal
