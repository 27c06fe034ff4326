#include "core/report/report_file.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/report/result_folder.h"
#include "tests/support/json.h"
#include "tests/support/make_result.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

class ReportFileTest : public testing::Test {
 protected:
  void write(const std::string& text) const { std::ofstream(folder / "report.json") << text; }

  std::filesystem::path folder = scratch_folder("report_file");
};

TEST_F(ReportFileTest, TellsTheWarningsAndTheCamerasOfARun) {
  CalibrationResult result = make_result();
  result.warnings = {"a fan blew"};
  result.cameras.resize(2);
  result.cameras[1].name = "blind";
  result.cameras[0].name = "left";
  result.cameras[0].given = {DistortionModel::equidistant, 640, 480, 300.5, 301.0, 319.5, 239.5,
                             {0.1, -0.02, 0.0, 0.003}};
  ASSERT_TRUE(write_result_folder(result, (folder / "result").string()));
  const auto report = read_report((folder / "result").string());
  ASSERT_TRUE(report && *report);
  EXPECT_THAT((*report)->warnings, ElementsAre("a fan blew"));
  EXPECT_THAT((*report)->cameras, ElementsAre("left", "blind"));
  ASSERT_EQ((*report)->intrinsics.count("left"), 1U);
  EXPECT_FALSE(json_of_file(folder / "result/report.json")["cameras"][1].contains("intrinsics"));
  const CameraIntrinsics& intrinsics = (*report)->intrinsics.at("left");
  EXPECT_EQ(intrinsics.model, DistortionModel::equidistant);
  EXPECT_EQ(intrinsics.width, 640);
  EXPECT_EQ(intrinsics.fx, 300.5);
  EXPECT_EQ(intrinsics.cy, 239.5);
  EXPECT_THAT(intrinsics.distortion, ElementsAre(0.1, -0.02, 0.0, 0.003));
}

TEST_F(ReportFileTest, TakesNothingFromWhatIsNotOurs) {
  const auto missing = read_report(folder.string());
  ASSERT_TRUE(missing);
  EXPECT_FALSE(*missing);
  write("[1, 2]");
  const auto another = read_report(folder.string());
  ASSERT_TRUE(another);
  EXPECT_FALSE(*another);
  write(R"({"rigcal": 1, "warnings": [7, "one"], "cameras": ["left", {"name": 3}, {"name": "right"}]})");
  const auto report = read_report(folder.string());
  ASSERT_TRUE(report && *report);
  EXPECT_THAT((*report)->warnings, ElementsAre("one"));
  EXPECT_THAT((*report)->cameras, ElementsAre("right"));
  EXPECT_TRUE((*report)->intrinsics.empty());
}

TEST_F(ReportFileTest, BelievesNoIntrinsicsThatAreNone) {
  for (const char* spoiled : {R"("fx": 0)", R"("fx": "wide")", R"("width": -640)", R"("distortion": [0.1])",
                              R"("distortion": [1, 2, 3, 4, "x"])"}) {
    write(
        std::string(
            R"({"rigcal": 1, "cameras": [{"name": "left", "intrinsics": {"model": "radtan", "width": 640, "height": 480,
      "fx": 300, "fy": 300, "cx": 320, "cy": 240, "distortion": [0, 0, 0, 0, 0], )") +
        spoiled + "}}]}");
    const auto report = read_report(folder.string());
    ASSERT_TRUE(report && *report) << spoiled;
    EXPECT_TRUE((*report)->intrinsics.empty()) << spoiled;
  }
}

TEST_F(ReportFileTest, SaysThatItIsDamaged) {
  for (const char* text : {"", "{", R"({"rigcal": 1, "warnings": ["a fan)"}) {
    write(text);
    const auto report = read_report(folder.string());
    ASSERT_FALSE(report) << text;
    EXPECT_EQ(report.error().kind, ErrorKind::input);
    EXPECT_THAT(report.error().message(), HasSubstr("report.json: is no JSON, or was cut or damaged"));
  }
}

TEST_F(ReportFileTest, RefusesANewerFormat) {
  write(R"({"rigcal": 2, "warnings": []})");
  const auto report = read_report(folder.string());
  ASSERT_FALSE(report);
  EXPECT_EQ(report.error().kind, ErrorKind::input);
  EXPECT_THAT(report.error().message(), HasSubstr("has the format 2, but this release reads format 1"));
}

}  // namespace
}  // namespace rigcal
