#include "core/io/patch_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/io/file_copy.h"
#include "core/io/pcd_file.h"
#include "tests/core/io/dump_bytes.h"
#include "tests/support/se3_matchers.h"

namespace {
int syncs_of_all_files = 0;
}  // namespace

// Stands in for the system's.
extern "C" int syncfs(int) noexcept {
  ++syncs_of_all_files;
  return 0;
}

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

Rig rig_of_three() {
  return *parse_rig(
      "rigcal: 1\nbase: a\nsensors:\n  a: {type: livox_avia}\n  b: {type: livox_mid40, folder: mid}\n"
      "  c: {type: lidar}\n  cam: {type: camera}\n",
      "rig.yaml");
}

/// A folder with empty files of these names.
std::string folder_with(const std::string& name, const std::vector<std::string>& files) {
  const std::string path = fresh_path(name);
  std::filesystem::create_directory(path);
  for (const std::string& file : files) {
    std::filesystem::create_directories(std::filesystem::path(path + "/" + file).parent_path());
    std::ofstream(path + "/" + file) << "";
  }
  return path;
}

std::string error_of(const std::string& path) {
  const Expected<PatchFolder> folder = list_patch_folder(path, rig_of_three());
  return folder ? std::string("no error") : folder.error().message();
}

TEST(PatchFolder, SortsStopsByNumberAndListsStrangers) {
  const std::string path = folder_with("patches", {"a/10.pcd", "a/9.pcd", "a/007.pcd", "a/notes.txt", "a/-1.pcd",
                                                   "mid/9.pcd", "image/cam/9.png", "avia/1.pcd", "b/1.pcd"});
  const Expected<PatchFolder> folder = list_patch_folder(path, rig_of_three());
  ASSERT_TRUE(folder) << folder.error().message();
  ASSERT_EQ(folder->patches.size(), 4U);
  ASSERT_EQ(folder->patches[0].size(), 3U);
  EXPECT_EQ(folder->patches[0][0].stop, 7);
  EXPECT_EQ(folder->patches[0][2].stop, 10);
  EXPECT_EQ(folder->patches[0][2].path, path + "/a/10.pcd");
  EXPECT_EQ(folder->patches[1].size(), 1U);  // found by its folder key
  EXPECT_TRUE(folder->patches[2].empty());
  EXPECT_THAT(folder->stops, ElementsAre(7, 9, 10));
  EXPECT_THAT(folder->unknown, ElementsAre("a/-1.pcd", "a/notes.txt", "avia", "b"));
  EXPECT_FALSE(folder->trajectory);
  EXPECT_THAT(
      reasons_of_unknown(*folder),
      ElementsAre("not used, since no sensor of the rig has that name or folder: avia, b",
                  "not used, since a cloud is named by the number of its stop, like 3.pcd: a/-1.pcd, a/notes.txt"));
}

TEST(CopyFile, SaysThatTheDiskIsFull) {
  const std::string from = write_text("to_copy", std::string(3'000'000, 'x'));
  const std::string to = fresh_path("copy");
  ASSERT_TRUE(copy_file(from, to));
  EXPECT_EQ(read_bytes(to), read_bytes(from));
  EXPECT_THAT(copy_file(from, "/dev/full").error().message(), HasSubstr("the disk is full; make room"));
  EXPECT_THAT(copy_file(fresh_path("nothing"), to).error().message(), HasSubstr("no such file"));
}

TEST(PatchFolder, ReadsATrajectoryByStopNumber) {
  const std::string path = folder_with("with_tum", {"a/0.pcd"});
  std::ofstream(path + "/trajectory.tum") << "# stop tx ty tz qx qy qz qw\n0 0 0 0 0 0 0 1\n12.0 1 2 3 0 0 1 0\n";
  const Expected<PatchFolder> folder = list_patch_folder(path, rig_of_three());
  ASSERT_TRUE(folder) << folder.error().message();
  ASSERT_EQ(folder->trajectory->size(), 2U);
  EXPECT_THAT(folder->trajectory->at(12), SE3Near(pose_deg(0, 0, 180, 1, 2, 3), 1e-9, 1e-9));
}

TEST(PatchFolder, RefusesATrajectoryOfTimes) {
  const std::string path = folder_with("with_times", {"a/0.pcd"});
  std::ofstream(path + "/trajectory.tum") << "0 0 0 0 0 0 0 1\n0.5 0 0 0 0 0 0 1\n";
  EXPECT_THAT(error_of(path), HasSubstr("trajectory.tum:2: the first column is no stop number"));
  std::ofstream(path + "/trajectory.tum") << "3 0 0 0 0 0 0 1\n\n3 0 0 0 0 0 0 1\n";
  EXPECT_THAT(error_of(path), HasSubstr("trajectory.tum:3: has stop 3 a second time"));
}

TEST(PatchFolder, OfCamerasAloneHasImagesAndNoClouds) {
  const Rig rig = *parse_rig("rigcal: 1\nbase: l\nsensors:\n  l: {type: camera}\n  r: {type: camera}\n", "rig.yaml");
  const auto folder = list_patch_folder(folder_with("cameras_alone", {"image/l/0.png", "clouds/0.pcd"}), rig);
  ASSERT_TRUE(folder) << folder.error().message();
  EXPECT_THAT(folder->stops, testing::IsEmpty());
  EXPECT_EQ(folder->patches.size(), 2U);
  EXPECT_THAT(folder->unknown, ElementsAre("clouds"));
  const auto none = list_patch_folder(folder_with("cameras_without", {"clouds/0.pcd"}), rig);
  ASSERT_FALSE(none);
  EXPECT_THAT(none.error().message(), HasSubstr("put them into image/<camera>/<stop>.png"));
}

TEST(PatchFolder, SaysWhatIsThereWhenNoSensorFits) {
  const std::string path = folder_with("strangers", {"avia/1.pcd", "mid_left/1.pcd"});
  EXPECT_THAT(error_of(path), HasSubstr("there are avia, mid_left"));
  EXPECT_THAT(error_of(path), HasSubstr("wanted are a, mid, c"));
  EXPECT_THAT(error_of(folder_with("nothing", {})), HasSubstr("is empty"));
  EXPECT_THAT(error_of(folder_with("no_clouds", {"a/x.txt"})), HasSubstr("hold no clouds"));
  EXPECT_THAT(error_of(folder_with("doubled", {"a/1.pcd", "a/01.pcd"})), HasSubstr("two clouds for stop 1"));
  EXPECT_THAT(error_of(fresh_path("no_folder")), HasSubstr("no such file"));
}

TEST(PatchFolder, SaysWhatKeepsFilesFromBeingClouds) {
  const std::string ply = error_of(folder_with("ply", {"a/0.ply", "a/1.PLY", "mid/0.ply"}));
  EXPECT_THAT(ply, HasSubstr("its folders hold no clouds that are read, but 3 other files, the first: a/0.ply"));
  EXPECT_THAT(ply, HasSubstr("PLY is not read: convert it to PCD"));
  EXPECT_THAT(ply, testing::Not(HasSubstr("0.pcd")));
  EXPECT_THAT(error_of(folder_with("stamps", {"a/1700000003800000000.pcd"})),
              testing::AllOf(HasSubstr("but 1 other file: a/1700000003800000000.pcd"), HasSubstr("not by a time")));
  const std::string path = folder_with("mixed", {"a/0.PCD", "a/1.pcd", "mid/0.ply", "mid/1700000003.8.pcd"});
  const Expected<PatchFolder> folder = list_patch_folder(path, rig_of_three());
  ASSERT_TRUE(folder) << folder.error().message();
  EXPECT_THAT(folder->stops, ElementsAre(0, 1));
  EXPECT_THAT(reasons_of_unknown(*folder),
              ElementsAre("not used, since PLY is not read: convert it to PCD: mid/0.ply", HasSubstr("not by a time")));
}

TEST(PatchFolder, NamesTenOfManyStrangers) {
  std::vector<std::string> files{"a/0.pcd"};
  for (int i = 0; i < 15; ++i) files.push_back("a/note" + std::to_string(10 + i) + ".txt");
  const Expected<PatchFolder> folder = list_patch_folder(folder_with("many", files), rig_of_three());
  ASSERT_TRUE(folder) << folder.error().message();
  EXPECT_THAT(reasons_of_unknown(*folder), ElementsAre(HasSubstr("a/note19.txt and 5 more")));
}

TEST(PatchFolderWriter, WritesWhatIsListedAgain) {
  const std::string path = fresh_path("written");
  Expected<PatchFolderWriter> writer = PatchFolderWriter::create(path + "/", rig_of_three());
  ASSERT_TRUE(writer);
  Patch patch{1, 4, {}};
  patch.points.push_back({1, 2, 3, 4, 5, 0});
  ASSERT_TRUE(writer->write(patch));
  const SE3 pose = pose_deg(1, 2, 3, 4, 5, 6);
  ASSERT_TRUE(writer->write_trajectory({{4, pose}}));
  EXPECT_FALSE(std::filesystem::exists(path));  // nothing that looks like a result before the end
  ASSERT_TRUE(writer->finish());
  const Expected<PatchFolder> folder = list_patch_folder(path, rig_of_three());
  ASSERT_TRUE(folder) << folder.error().message();
  ASSERT_EQ(folder->patches[1].size(), 1U);
  EXPECT_EQ(read_pcd(folder->patches[1][0].path)->points.size(), 1U);
  EXPECT_THAT(folder->trajectory->at(4), SE3Near(pose, 1e-12, 0.0));  // all digits are written
}

TEST(PatchFolderWriter, NeverOverwrites) {
  const std::string path = folder_with("mine", {"precious.txt"});
  const Expected<PatchFolderWriter> writer = PatchFolderWriter::create(path, rig_of_three());
  ASSERT_FALSE(writer);
  EXPECT_THAT(writer.error().message(), HasSubstr("exists already"));
  EXPECT_TRUE(std::filesystem::exists(path + "/precious.txt"));
}

TEST(PatchFolderWriter, IsOnTheDiskBeforeItAppears) {
  Expected<PatchFolderWriter> writer = PatchFolderWriter::create(fresh_path("safe"), rig_of_three());
  ASSERT_TRUE(writer);
  ASSERT_TRUE(writer->write({0, 0, {{1.0F, 2.0F, 3.0F}}}));
  syncs_of_all_files = 0;
  ASSERT_TRUE(writer->finish());
  EXPECT_EQ(syncs_of_all_files, 1);
}

TEST(StagedFolder, ReplacesOnlyItsOwnKind) {
  const std::string path = folder_with("result", {"extrinsics.yaml"});
  {
    Expected<StagedFolder> folder = StagedFolder::replace(path, {"extrinsics.yaml", "report.json"});
    ASSERT_TRUE(folder);
    std::ofstream(folder->path() + "/report.json") << "{}";
    ASSERT_TRUE(folder->commit());
  }
  EXPECT_TRUE(std::filesystem::exists(path + "/report.json"));
  EXPECT_FALSE(std::filesystem::exists(path + "/extrinsics.yaml"));
  std::ofstream(path + "/thesis.tex") << "x";
  const Expected<StagedFolder> refused = StagedFolder::replace(path, {"extrinsics.yaml", "report.json"});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr("holds 'thesis.tex'"));
  EXPECT_TRUE(std::filesystem::exists(path + "/report.json"));
}

TEST(StagedFolder, TriesItsPlaceAndLeavesNothingThere) {
  const std::string parent = folder_with("place", {"file"});
  ASSERT_TRUE(StagedFolder::check_place(parent + "/not/there/yet/"));
  const Expected<void> refused = StagedFolder::check_place(parent + "/file/result");
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().kind, ErrorKind::system);
  EXPECT_THAT(refused.error().message(), HasSubstr("/place/file is a file and no folder; choose another place"));
  std::filesystem::remove(parent + "/file");
  EXPECT_TRUE(std::filesystem::is_empty(parent));
}

TEST(StagedFolder, LeavesNothingWhenNotCommitted) {
  const std::string parent = folder_with("parent", {});
  { ASSERT_TRUE(StagedFolder::create(parent + "/new")); }
  EXPECT_TRUE(std::filesystem::is_empty(parent));
}

}  // namespace
}  // namespace rigcal
