#include "core/report/result_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <set>

#include "tests/support/files.h"
#include "tests/support/make_result.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

class ResultFolder : public testing::Test {
 protected:
  static std::set<std::string> names(const fs::path& folder) {
    std::set<std::string> found;
    for (const auto& entry : fs::directory_iterator(folder)) found.insert(entry.path().filename());
    return found;
  }
  static void write(const fs::path& path, const std::string& text) { std::ofstream(path) << text; }

  fs::path root = scratch_folder("result_folder");
};

TEST_F(ResultFolder, HoldsAllFilesAndLeavesNothingBesideIt) {
  ASSERT_TRUE(write_result_folder(make_result(), root / "deep" / "result/"));
  EXPECT_THAT(names(root / "deep" / "result"),
              ElementsAre("extrinsics.yaml", "map.ply", "report.html", "report.json", "trajectory.tum"));
  EXPECT_THAT(names(root / "deep"), ElementsAre("result"));
}

TEST_F(ResultFolder, ReplacesAnOlderResultAsAWhole) {
  CalibrationResult result = make_result();
  ASSERT_TRUE(write_result_folder(result, root / "result"));
  write(root / "result" / "report.html", "from an older run");
  result.method = "planes";
  ASSERT_TRUE(write_result_folder(result, root / "result"));
  EXPECT_THAT(text_of(root / "result" / "extrinsics.yaml"), HasSubstr("method: planes"));
  EXPECT_THAT(text_of(root / "result" / "report.html"), testing::Not(HasSubstr("from an older run")));
  EXPECT_THAT(names(root), ElementsAre("result"));
}

TEST_F(ResultFolder, HoldsTheOverlaysUnderTheirCamerasAndStops) {
  CalibrationResult result = make_result();
  result.trajectory[2].stop.index = 17;
  result.overlays = {{"camera", 0, OverlayKind::edges, {1, 2}},
                     {"camera", 2, OverlayKind::edges, {3}},
                     {"camera", 2, OverlayKind::map, {4, 5, 6}}};
  ASSERT_TRUE(write_result_folder(result, root / "result"));
  const fs::path overlays = root / "result" / "overlays";
  EXPECT_THAT(names(overlays), ElementsAre("camera_0.jpg", "camera_17.jpg", "camera_17_map.jpg"));
  EXPECT_EQ(text_of(overlays / "camera_17_map.jpg"), "\x04\x05\x06");
  // Another result without a camera takes its place, overlays included.
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  EXPECT_FALSE(fs::exists(overlays));
}

TEST_F(ResultFolder, IsNotReplacedWhereSomethingElseLiesAmongItsOverlays) {
  CalibrationResult result = make_result();
  result.overlays = {{"camera", 0, OverlayKind::edges, {1, 2}}};
  ASSERT_TRUE(write_result_folder(result, root / "result"));
  write(root / "result" / "overlays" / "notes.txt", "what was seen");
  const Expected<void> done = write_result_folder(result, root / "result");
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message(), HasSubstr("overlays/notes.txt"));
  EXPECT_EQ(text_of(root / "result" / "overlays" / "notes.txt"), "what was seen");
}

TEST_F(ResultFolder, ReplacesWhatALinkPointsToAndKeepsTheLink) {
  ASSERT_TRUE(write_result_folder(make_result(), root / "real"));
  fs::create_directory_symlink(root / "real", root / "latest");
  CalibrationResult result = make_result();
  result.method = "planes";
  ASSERT_TRUE(write_result_folder(result, root / "latest"));
  EXPECT_TRUE(fs::is_symlink(root / "latest"));
  EXPECT_THAT(text_of(root / "real" / "extrinsics.yaml"), HasSubstr("method: planes"));
}

TEST_F(ResultFolder, FillsAnEmptyFolder) {
  fs::create_directory(root / "result");
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  EXPECT_TRUE(fs::exists(root / "result" / "extrinsics.yaml"));
}

TEST_F(ResultFolder, NeverReplacesAFolderThatIsNoResult) {
  fs::create_directory(root / "thesis");
  write(root / "thesis" / "chapter1.tex", "years of work");
  const Expected<void> done = write_result_folder(make_result(), root / "thesis");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::input);
  EXPECT_THAT(done.error().message(), HasSubstr("chapter1.tex"));
  EXPECT_EQ(text_of(root / "thesis" / "chapter1.tex"), "years of work");
  EXPECT_THAT(names(root), ElementsAre("thesis"));
}

TEST_F(ResultFolder, NeverReplacesAResultToWhichTheUserAddedAFile) {
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  write(root / "result" / "notes.txt", "mine");
  EXPECT_FALSE(write_result_folder(make_result(), root / "result"));
  EXPECT_EQ(text_of(root / "result" / "notes.txt"), "mine");
}

TEST_F(ResultFolder, NeverReplacesForeignFilesThatOnlyHaveTheNamesOfOurs) {
  fs::create_directory(root / "other");
  write(root / "other" / "map.ply", "ply of another tool");
  EXPECT_FALSE(check_result_target(root / "other"));
  write(root / "other" / "extrinsics.yaml", "camera: 1\n");
  EXPECT_FALSE(check_result_target(root / "other"));
}

TEST_F(ResultFolder, NeverReplacesAFile) {
  write(root / "result", "a file");
  EXPECT_FALSE(write_result_folder(make_result(), root / "result"));
  EXPECT_EQ(text_of(root / "result"), "a file");
}

TEST_F(ResultFolder, LeavesTheOlderResultWhenTheNewOneIsNotSound) {
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  const std::string before = text_of(root / "result" / "extrinsics.yaml");
  CalibrationResult broken = make_result();
  broken.sensors[1].T_base_sensor->t.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(write_result_folder(broken, root / "result"));
  EXPECT_EQ(text_of(root / "result" / "extrinsics.yaml"), before);
  EXPECT_THAT(names(root), ElementsAre("result"));
}

TEST_F(ResultFolder, SaysThatTheSystemRefusedWhereNoFolderCanBeMade) {
  const Expected<void> done = write_result_folder(make_result(), "/proc/rigcal-result");
  ASSERT_FALSE(done);
  EXPECT_EQ(done.error().kind, ErrorKind::system);
}

TEST_F(ResultFolder, WritesTheMapAsPlyThatOtherToolsRead) {
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  const std::string ply = text_of(root / "result" / "map.ply");
  const std::string end = "end_header\n";
  const std::size_t body = ply.find(end) + end.size();
  EXPECT_THAT(ply.substr(0, body), HasSubstr("sensors: 0 avia 1 mid40_left 2 mid40_right\nelement vertex 2\n"));
  ASSERT_EQ(ply.size() - body, 2U * 17U);  // three floats and five bytes a point
  float z = 0.0F;
  std::memcpy(&z, ply.data() + body + 8, 4);
  EXPECT_EQ(z, 3.0F);
  EXPECT_EQ(static_cast<unsigned char>(ply[body + 15]), 200);
  EXPECT_EQ(ply[body + 17 + 16], 1);
}

TEST_F(ResultFolder, IsTriedAtItsPlaceBeforehandAndNothingIsLeft) {
  write(root / "file", "");
  const Expected<void> below_a_file = check_result_target(root / "file/deep/result");
  ASSERT_FALSE(below_a_file);
  EXPECT_EQ(below_a_file.error().kind, ErrorKind::system);
  EXPECT_THAT(below_a_file.error().message(), HasSubstr((root / "file").string() + " is a file and no folder"));
  const Expected<void> long_name = check_result_target(root / std::string(300, 'x'));
  ASSERT_FALSE(long_name);
  EXPECT_EQ(long_name.error().kind, ErrorKind::system);
  ASSERT_TRUE(check_result_target(root / "deep/er/result/"));
  EXPECT_THAT(names(root), ElementsAre("file"));
  ASSERT_TRUE(write_result_folder(make_result(), root / "result"));
  ASSERT_TRUE(check_result_target(root / "result"));
  EXPECT_THAT(names(root), ElementsAre("file", "result"));
}

}  // namespace
}  // namespace rigcal
