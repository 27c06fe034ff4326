// `rigcal export` of a result as a user runs it; what the files hold is tested in core/report.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "core/report/result_folder.h"
#include "core/report/result_formats.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/make_result.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

class ExportResult : public testing::Test {
 protected:
  void SetUp() override {
    scratch = scratch_folder("export_result");
    CalibrationResult result = make_result();
    ASSERT_TRUE(write_result_folder(result, (scratch / "partly").string()));
    result.sensors.resize(1);
    result.status = Status::good;
    result.sensors.push_back(result.sensors[0]);
    result.sensors[1].name = "mid40";
    result.sensors[1].T_base_sensor->t = {1.0, 2.0, 3.0};
    result.map.clear();
    ASSERT_TRUE(write_result_folder(result, (scratch / "good").string()));
  }

  [[nodiscard]] ProgramRun rigcal(const std::string& arguments) const { return run_rigcal(arguments, scratch); }

  fs::path scratch;
};

TEST_F(ExportResult, WritesAGoodResultInEveryFormat) {
  for (const std::string& format : result_format_names()) {
    const ProgramRun run = rigcal("export good --format " + format + " --out " + format + ".txt --json");
    EXPECT_EQ(run.code, 0) << format << run.err;
    EXPECT_EQ(run.err, "") << format;
    const auto json = parse_json(run.out);
    EXPECT_TRUE(fits_schema("export.json", json));
    EXPECT_THAT(json["left_out"], IsEmpty());
    EXPECT_GT(fs::file_size(scratch / (format + ".txt")), 10U) << format;
  }
}

TEST_F(ExportResult, TakesASensorWhoseIntrinsicsWereFoundForACamera) {
  const fs::path file = scratch / "refined.yaml";
  std::ofstream(file)
      << "rigcal: 1\nbase: avia\nstatus: good\nsensors:\n"
         "  avia: {status: good, translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n"
         "  cam: {status: good, translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1], intrinsics: {model: radtan, "
         "width: 640, height: 480, fx: 500, fy: 501, cx: 320, cy: 240, distortion: [0.1, 0, 0, 0]}}\n";
  EXPECT_EQ(rigcal("export refined.yaml --format colmap --out rig_config.json").code, 0);
  const auto cameras = json_of_file(scratch / "rig_config.json")[0]["cameras"];
  ASSERT_EQ(cameras.size(), 1U) << "the LiDAR is none";
  EXPECT_EQ(cameras[0]["camera_params"][1], 501.0);
}

TEST_F(ExportResult, MakesTheFoldersThatItsFileIsToLieIn) {
  EXPECT_EQ(rigcal("export refined.yaml --format opencv --out of/a/robot/rig.yml").code, 3)
      << "there is no such result";
  EXPECT_FALSE(fs::exists(scratch / "of"));
  EXPECT_EQ(rigcal("export partly/extrinsics.yaml --format urdf --out of/a/robot/rig.urdf").code, 1);
  EXPECT_TRUE(fs::is_regular_file(scratch / "of/a/robot/rig.urdf"));
}

TEST_F(ExportResult, LeavesAFailedSensorOutAndSaysSo) {
  const ProgramRun run = rigcal("export partly/extrinsics.yaml --format ros2-tf --out rig.launch.xml --json");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("mid40_right is failed: it has no transform and is left out"));
  EXPECT_THAT(run.err, HasSubstr("mid40_left is weak"));
  const auto json = parse_json(run.out);
  EXPECT_EQ(json["sensors"], (std::vector<std::string>{"avia", "mid40_left"}));
  EXPECT_EQ(json["left_out"], (std::vector<std::string>{"mid40_right"}));
  EXPECT_EQ(json["status"], "failed");
}

TEST_F(ExportResult, KeepsWhatIsKnownWorstInJson) {
  CalibrationResult result = make_result();
  result.sensors[1].weak_directions = {{false, Vector3d::UnitZ(), 0.25, false, true, "a level surface"},
                                       {true, Vector3d::UnitX(), pi / 4.0, true, false, "an upright one"}};
  ASSERT_TRUE(write_result_folder(result, (scratch / "weak").string()));
  EXPECT_EQ(rigcal("export weak --format json --out weak.json").code, 1);
  const auto json = json_of_file(scratch / "weak.json");
  EXPECT_TRUE(fits_schema("extrinsics.json", json));
  EXPECT_FALSE(json["sensors"][result.sensors[0].name].contains("weak_directions"));
  const auto& weak = json["sensors"][result.sensors[1].name]["weak_directions"];
  ASSERT_EQ(weak.size(), 2U);
  EXPECT_EQ(weak[0]["of"], "place");
  EXPECT_EQ(weak[0]["axis"], (std::vector<double>{0.0, 0.0, 1.0}));
  EXPECT_EQ(weak[0]["bound_m"], 0.25);
  EXPECT_EQ(weak[0]["frozen"], true);
  EXPECT_NEAR(weak[1]["bound_deg"], 45.0, 1e-12);
  EXPECT_EQ(weak[1]["missing"], "an upright one");
}

TEST_F(ExportResult, WritesATruthByTheSchemaOfResults) {
  std::ofstream(scratch / "ground_truth.yaml") << "rigcal: 1\nbase: avia\nsensors:\n"
                                                  "  avia: {translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n"
                                                  "  mid40: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n"
                                                  "stops:\n  - {stop: 0, start_ns: 0, end_ns: 1, T_G_base: "
                                                  "{translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}}\n";
  const ProgramRun run = rigcal("export ground_truth.yaml --format json --out truth.json --json");
  EXPECT_EQ(run.code, 0);
  EXPECT_TRUE(fits_schema("export.json", parse_json(run.out)));
  EXPECT_FALSE(parse_json(run.out).contains("status")) << "nobody judged it";
  auto truth = json_of_file(scratch / "truth.json");
  EXPECT_FALSE(truth["sensors"]["mid40"].contains("covariance")) << "it is not known exactly, it is not known";
  EXPECT_TRUE(fits_schema("extrinsics.json", truth));
  truth["method"] = "targetless";
  EXPECT_FALSE(fits_schema("extrinsics.json", truth)) << "what was found has a covariance";
}

TEST_F(ExportResult, TakesTheCamerasFromTheRigFile) {
  std::ofstream(scratch / "rig.yaml") << "rigcal: 1\nname: r\nbase: avia\nsensors:\n"
                                         "  avia: {type: lidar}\n"
                                         "  mid40: {type: camera, driver: images, intrinsics: {model: radtan, width: "
                                         "640, height: 480, fx: 500, fy: 500, cx: 320, cy: 240, distortion: [0.1, 0, "
                                         "0, 0, 0]}}\n";
  const ProgramRun run = rigcal("export good --rig rig.yaml --format colmap --out rig_config.json");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto cameras = json_of_file(scratch / "rig_config.json")[0]["cameras"];
  ASSERT_EQ(cameras.size(), 1U);
  EXPECT_EQ(cameras[0]["image_prefix"], "mid40/");
  EXPECT_EQ(cameras[0]["camera_params"][2], 320.5);
}

TEST_F(ExportResult, KnowsTheCamerasOfAResultFolder) {
  CalibrationResult result = make_result();
  result.sensors.resize(1);
  result.sensors.resize(3, result.sensors[0]);
  result.sensors[1].name = "mid40";
  result.sensors[2].name = "left";
  result.status = Status::good;
  result.cameras.resize(1);
  result.cameras[0].name = "left";
  ASSERT_TRUE(write_result_folder(result, (scratch / "seen").string()));
  const auto sensors = [&](const std::string& arguments) {
    const ProgramRun run = rigcal("export " + arguments + " --json");
    EXPECT_EQ(run.code, 0) << run.err;
    return std::pair{parse_json(run.out)["sensors"].get<std::vector<std::string>>(), run.err};
  };
  EXPECT_EQ(sensors("seen --format mlcc --out a").first, std::vector<std::string>{"mid40"});
  const auto [cameras, wanted] = sensors("seen --format kalibr --out b");
  EXPECT_EQ(cameras, std::vector<std::string>{"left"});
  EXPECT_THAT(wanted, HasSubstr("left is known without intrinsics"));
  EXPECT_EQ(sensors("seen --format colmap --out c").first, std::vector<std::string>{"left"});
  // Its extrinsics alone do not tell.
  const auto [both, warned] = sensors("seen/extrinsics.yaml --format mlcc --out d");
  EXPECT_EQ(both, (std::vector<std::string>{"mid40", "left"}));
  EXPECT_THAT(warned, HasSubstr("no sensor is known for a camera"));
  EXPECT_THAT(warned, HasSubstr("give --rig RIG"));
  EXPECT_EQ(sensors("seen/extrinsics.yaml --format urdf --out e").second, "") << "to which all sensors are alike";
  std::ofstream(scratch / "other.yaml") << "rigcal: 1\nbase: mid40\nsensors:\n  mid40: {type: livox_mid40}\n";
  EXPECT_THAT(sensors("seen/extrinsics.yaml --rig other.yaml --format kalibr --out f").second,
              HasSubstr("left is not in other.yaml, so that it is written as a LiDAR"));
}

TEST_F(ExportResult, KnowsTheCamerasOfARigFileThatStandsForAResult) {
  std::ofstream(scratch / "rig.yaml") << "rigcal: 1\nname: r\nbase: avia\nsensors:\n"
                                         "  avia: {type: lidar}\n"
                                         "  cam: {type: camera, driver: images, topic: /cam, intrinsics: {model: "
                                         "radtan, width: 640, height: 480, fx: 500, fy: 501, cx: 320, cy: 240, "
                                         "distortion: [0.1, 0, 0, 0]}}\n"
                                         "initial_extrinsics:\n"
                                         "  cam: {translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n";
  const ProgramRun run = rigcal("export rig.yaml --format kalibr --out chain.yaml");
  EXPECT_EQ(run.code, 0);
  EXPECT_EQ(run.err, "");
  EXPECT_THAT(text_of(scratch / "chain.yaml"), HasSubstr("rostopic: \"/cam\""));
  EXPECT_EQ(rigcal("export rig.yaml --format json --out rig.json").code, 0);
  EXPECT_EQ(json_of_file(scratch / "rig.json")["sensors"]["cam"]["intrinsics"]["fy"], 501.0);
}

TEST_F(ExportResult, WarnsOfCamerasWithoutIntrinsics) {
  std::ofstream(scratch / "rig.yaml") << "rigcal: 1\nname: r\nbase: avia\nsensors:\n  avia: {type: lidar}\n"
                                         "  mid40: {type: camera, driver: images}\n";
  for (const std::string format : {"opencv", "colmap"}) {
    EXPECT_THAT(rigcal("export good --rig rig.yaml --format " + format + " --out " + format).err,
                HasSubstr("mid40 is known without intrinsics and is written without: give --rig RIG with them"));
  }
  EXPECT_THAT(rigcal("export good/extrinsics.yaml --format opencv --out a").err, HasSubstr("none has intrinsics"));
}

TEST_F(ExportResult, NamesWhatIsWrongAndTouchesNothing) {
  std::ofstream(scratch / "mine.txt") << "years of work";
  const std::string cases[] = {"export good --format urdf --out mine.txt", "export nothing --format urdf --out a",
                               "export . --format urdf --out a", "export mine.txt --format urdf --out a",
                               "export good --rig nothing.yaml --format urdf --out a"};
  for (const std::string& arguments : cases) {
    const ProgramRun run = rigcal(arguments);
    EXPECT_EQ(run.code, 3) << arguments;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  EXPECT_EQ(fs::file_size(scratch / "mine.txt"), 13U);
  EXPECT_FALSE(fs::exists(scratch / "a"));
  const ProgramRun within_a_file = rigcal("export good --format urdf --out mine.txt/a");
  EXPECT_EQ(within_a_file.code, 4);
  EXPECT_THAT(within_a_file.err, HasSubstr("mine.txt: cannot be made, it is a file and no folder"));
}

}  // namespace
}  // namespace rigcal
