#include "core/report/report_file.h"

#include <gmock/gmock.h>

#include <fstream>

#include "core/report/result_folder.h"
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
  result.cameras.resize(1);
  result.cameras[0].name = "left";
  ASSERT_TRUE(write_result_folder(result, (folder / "result").string()));
  const auto report = read_report((folder / "result").string());
  ASSERT_TRUE(report && *report);
  EXPECT_THAT((*report)->warnings, ElementsAre("a fan blew"));
  EXPECT_THAT((*report)->cameras, ElementsAre("left"));
}

TEST_F(ReportFileTest, TakesNothingFromWhatIsNotOurs) {
  const auto missing = read_report(folder.string());
  ASSERT_TRUE(missing);
  EXPECT_FALSE(*missing);
  for (const char* text : {"", "{", "[1, 2]"}) {
    write(text);
    const auto report = read_report(folder.string());
    ASSERT_TRUE(report) << text;
    EXPECT_FALSE(*report) << text;
  }
  write(R"({"rigcal": 1, "warnings": [7, "one"], "cameras": ["left", {"name": 3}, {"name": "right"}]})");
  const auto report = read_report(folder.string());
  ASSERT_TRUE(report && *report);
  EXPECT_THAT((*report)->warnings, ElementsAre("one"));
  EXPECT_THAT((*report)->cameras, ElementsAre("right"));
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
