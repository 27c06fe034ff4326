// rigcal inspect of results and of sessions that came as patches, from files to exit code.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "core/report/result_folder.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class InspectResult : public testing::Test {
 protected:
  // Two LiDARs beside the base, known to 0.5 mm and 0.005 degrees.
  static CalibrationResult good() {
    CalibrationResult result;
    result.base = "avia";
    result.method = "targetless";
    result.status = Status::good;
    for (const char* name : {"avia", "left", "right"}) {
      SensorResult sensor{name, Status::good, {}, SE3{}, Matrix6d::Zero()};
      if (!result.sensors.empty()) {
        Vector6d xi;
        xi << 0.0, 0.0, 0.5 * static_cast<double>(result.sensors.size()), 0.1, 0.2, 0.3;
        sensor.T_base_sensor = SE3::exp(xi);
        sensor.covariance.diagonal() << Vector3d::Constant(std::pow(to_rad(0.005), 2)), Vector3d::Constant(0.25e-6);
      }
      result.sensors.push_back(sensor);
    }
    result.warnings = {"a fan blew"};
    return result;
  }
  static CalibrationResult with_left_moved_by(double m) {
    CalibrationResult result = good();
    result.sensors[1].T_base_sensor->t += result.sensors[1].T_base_sensor->R * Vector3d(0.0, m, 0.0);
    return result;
  }
  void write(const CalibrationResult& result, const std::string& name) const {
    ASSERT_TRUE(write_result_folder(result, scratch / name));
  }
  [[nodiscard]] ProgramRun inspect(const std::string& arguments) const {
    return run_rigcal("inspect " + arguments, scratch);
  }

  std::filesystem::path scratch = scratch_folder("inspect");
};

TEST_F(InspectResult, RefusesAReportOfANewerRelease) {
  write(good(), "newer");
  auto report = json_of_file(scratch / "newer/report.json");
  report["rigcal"] = 2;
  std::ofstream(scratch / "newer/report.json") << report;
  const ProgramRun run = inspect("newer");
  EXPECT_EQ(run.code, 3);
  EXPECT_THAT(run.err, HasSubstr("report.json: has the format 2, but this release reads format 1; use rigcal 2.0"));
}

TEST_F(InspectResult, SaysTheVerdictInTheWordsOfThePage) {
  CalibrationResult result = good();
  result.status = Status::weak;
  result.sensors[2].status = Status::weak;
  result.sensors[2].reasons = {"its translation is known to 14.0 mm only"};
  write(result, "result");
  const ProgramRun run = inspect("result");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("a fan blew"));
  const std::string html = text_of(scratch / "result/report.html");
  for (const char* words : {"2 of 3 sensors are good: right is weak.", "its translation is known to 14.0 mm only",
                            "known to 1.4 mm and 0.014 degrees (95 %)"}) {
    EXPECT_THAT(run.out, HasSubstr(words));
    EXPECT_NE(html.find(words), std::string::npos) << words;
  }
  const auto json = parse_json(inspect("result --json").out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["status"], "weak");
  EXPECT_EQ(json["warnings"][0], "a fan blew");
}

TEST_F(InspectResult, OfGoodOnesEndsWithZero) {
  write(good(), "result");
  const ProgramRun run = inspect("result");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("good: All 3 sensors are good."));
  EXPECT_EQ(inspect("result/extrinsics.yaml").code, 0);
}

TEST_F(InspectResult, ReadsWhatExportMadeOfIt) {
  CalibrationResult result = good();
  result.status = result.sensors[2].status = Status::weak;
  result.sensors[2].reasons = {"its translation is known to 14.0 mm only"};
  write(result, "result");
  ASSERT_EQ(run_rigcal("export result --format json --out result.json", scratch).code, 1);
  std::filesystem::copy_file(scratch / "result.json", scratch / "named otherwise");
  for (const char* file : {"result.json", "'named otherwise'"}) {
    const ProgramRun run = inspect(file);
    EXPECT_EQ(run.code, 1) << run.err;
    EXPECT_THAT(run.out, HasSubstr("2 of 3 sensors are good: right is weak."));
    EXPECT_THAT(run.out, HasSubstr("its translation is known to 14.0 mm only"));
  }
  EXPECT_EQ(inspect("result result.json").code, 0);
}

TEST_F(InspectResult, RefusesARigFileThatIsOfNoUse) {
  write(good(), "may");
  for (const char* results : {"may", "may may", "may/extrinsics.yaml", "may/extrinsics.yaml may"}) {
    const ProgramRun run = inspect(std::string(results) + " --rig rig.yaml");
    EXPECT_EQ(run.code, 2) << results;
    EXPECT_THAT(run.err, HasSubstr("--rig: is of no use with a result"));
  }
}

TEST_F(InspectResult, SaysWhichSensorMovedBetweenTwo) {
  write(good(), "may");
  write(with_left_moved_by(0.005), "june");
  const ProgramRun run = inspect("may june");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("left moved by 5.0 mm and 0.000 degrees"));
  EXPECT_THAT(run.out, HasSubstr("1 other is where it was."));
  const auto json = parse_json(inspect("may june --json").out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["kind"], "comparison");
  EXPECT_EQ(json["same"], false);
  EXPECT_EQ(json["moves"][0]["verdict"], "moved");
  EXPECT_NEAR(json["moves"][0]["by_axis_mm"][1], 5.0, 1e-6);
  EXPECT_EQ(json["moves"][1]["verdict"], "same");
}

TEST_F(InspectResult, SaysThatNothingMovedBetweenTwo) {
  write(good(), "may");
  write(with_left_moved_by(0.0005), "june");
  const ProgramRun run = inspect("may june");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.out, HasSubstr("Nothing moved: 2 sensors are where they were."));
  EXPECT_THAT(run.out, Not(HasSubstr("not compared")));
}

// The same rig as told from its left LiDAR.
CalibrationResult with_left_as_base(CalibrationResult result) {
  const SE3 T_left_avia = result.sensors[1].T_base_sensor->inverse();
  result.sensors[0].covariance = result.sensors[1].covariance;
  result.sensors[1].covariance.setZero();
  for (SensorResult& sensor : result.sensors) sensor.T_base_sensor = T_left_avia * *sensor.T_base_sensor;
  result.base = "left";
  return result;
}

TEST_F(InspectResult, ComparesResultsOfTwoBases) {
  write(good(), "may");
  write(with_left_as_base(good()), "june");
  const ProgramRun run = inspect("may june");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out, HasSubstr("as seen from avia, since the results have two bases, avia and left"));
  write(with_left_as_base(with_left_moved_by(0.02)), "july");
  EXPECT_EQ(inspect("may july").code, 1);
  EXPECT_THAT(inspect("may july").out, HasSubstr("left moved by 20.0 mm"));
  const auto json = parse_json(inspect("may july --json").out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["base"], "avia");
  EXPECT_EQ(json["bases"], nlohmann::json({"avia", "left"}));
}

TEST_F(InspectResult, RefusesWhatCannotBeCompared) {
  write(good(), "may");
  CalibrationResult other = good();
  for (SensorResult& sensor : other.sensors) sensor.name += "_2";
  other.base += "_2";
  write(other, "june");
  EXPECT_EQ(inspect("may june").code, 3);
  EXPECT_THAT(inspect("may june").err, HasSubstr("two bases"));
  EXPECT_EQ(inspect("may nowhere").code, 3);
  EXPECT_EQ(inspect("may june july").code, 2);
}

// Two stops of a LiDAR, and a camera's images of them; none of these is opened.
class InspectSession : public testing::Test {
 protected:
  void SetUp() override {
    for (const char* folder : {"session/patches/top", "session/images/eye"})
      std::filesystem::create_directories(scratch / folder);
    put("session/rig.yaml", "rigcal: 1\nbase: top\nsensors:\n  top: {type: lidar}\n  eye: {type: camera}\n");
    put_end("6");
    for (const char* stop : {"0", "1"}) {
      put("session/patches/top/" + std::string(stop) + ".pcd",
          "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 1\nHEIGHT 1\n"
          "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 1\nDATA ascii\n1 2 3\n");
      put("session/images/eye/00000" + std::string(stop) + ".png", "an image");
    }
    put_frames("000000.png,5,,,,0\n000001.png,6,,,,1\n");
  }

  void put(const std::string& name, const std::string& text) const { std::ofstream(scratch / name) << text; }
  void put_end(const std::string& end_ns) const {
    put("session/session.json",
        "{\"format\": 1, \"start_ns\": 4, \"end_ns\": " + end_ns + ", \"gaps\": [\"run.bag ends in a message\"]}");
  }
  void put_frames(const std::string& lines) const {
    put("session/images/eye/frames.csv", "file,stamp_ns,trigger,exposure_us,device_stamp,stop\n" + lines);
  }
  [[nodiscard]] ProgramRun inspect(const std::string& arguments) const {
    return run_rigcal("inspect " + arguments, scratch);
  }

  std::filesystem::path scratch = scratch_folder("inspect");
};

TEST_F(InspectSession, OfWholePatchesEndsWithZero) {
  const ProgramRun run = inspect("session --json");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["kind"], "session");
  EXPECT_EQ(json["path"], "session");
  EXPECT_EQ(json["complete"], true);
  EXPECT_EQ(json["stops"].size(), 2U);
  EXPECT_EQ(json["images"]["eye"]["files"], 2);
  EXPECT_THAT(json["warnings"], IsEmpty());
}

TEST_F(InspectSession, OfPatchesWithoutAnEndSaysThatTheRecordingWasCutShort) {
  put_end("null");
  const ProgramRun run = inspect("session --json");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("session has no end: the recording that it was made from was cut short"));
  EXPECT_THAT(run.err, HasSubstr("run.bag ends in a message"));
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["complete"], false);
}

TEST_F(InspectSession, SaysWhyImagesCannotBeUsed) {
  for (const auto& [lines, reason] : {std::pair{"000000.png,nan,,,,0\n", "frames.csv:2: stamp_ns is 'nan'"},
                                      {"../../../etc/passwd,5,,,,0\n", "frames.csv:2: "},
                                      {"7.png,5,,,,0\n", "1 of the 1 images in frames.csv are missing, the first: "}}) {
    put_frames(lines);
    const ProgramRun run = inspect("session --json");
    EXPECT_EQ(run.code, 1) << lines;
    EXPECT_THAT(run.err, HasSubstr("the images of eye cannot be used: ")) << lines;
    EXPECT_THAT(run.err, HasSubstr(reason));
    EXPECT_TRUE(fits_schema("inspect.json", parse_json(run.out)));
  }
  put("session/images/eye/frames.csv", "name,time\n000000.png,5\n");
  EXPECT_EQ(inspect("session").code, 1);
  EXPECT_THAT(inspect("session").err, HasSubstr("frames.csv:1: the first line is not the header"));
}

TEST_F(InspectSession, OfWhichAnImageIsMissingOrAllAreWarnsAlone) {
  put_frames("");
  EXPECT_EQ(inspect("session").code, 0);
  EXPECT_THAT(inspect("session").err, HasSubstr("no image of eye is there: its folder session/images/eye holds none"));
  put_frames("000000.png,5,,,,0\n7.png,6,,,,1\n");
  const ProgramRun run = inspect("session");
  EXPECT_EQ(run.code, 0);
  EXPECT_THAT(run.err,
              HasSubstr("eye: 1 of the 2 images in frames.csv are missing, the first: session/images/eye/7.png"));
}

TEST_F(InspectSession, LooksAtNoImagesThatNoCameraTakes) {
  std::filesystem::create_directories(scratch / "session/images/thumbnails");
  put("session/images/thumbnails/frames.csv", "none\n");
  EXPECT_EQ(inspect("session").code, 0);
  EXPECT_THAT(inspect("session").err, IsEmpty());
}

}  // namespace
}  // namespace rigcal
