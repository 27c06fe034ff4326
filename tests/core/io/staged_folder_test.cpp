// Folders that cannot change places: see decision 003.
#include "core/io/staged_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sched.h>
#include <sys/inotify.h>
#include <sys/mount.h>
#include <unistd.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <thread>

#include "core/io/folder_contents.h"
#include "tests/support/files.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;

const std::vector<std::string> own_entries{"extrinsics.yaml", "report.html", "overlays"};

void write(const fs::path& path, const std::string& text) {
  fs::create_directories(path.parent_path());
  std::ofstream(path) << text;
}

Expected<void> replace_result(const fs::path& result) {
  Expected<StagedFolder> staged = StagedFolder::replace(result, own_entries);
  if (!staged) return staged.error();
  write(staged->path() + "/extrinsics.yaml", "new");
  write(staged->path() + "/overlays/new.jpg", "new");
  write(staged->path() + "/report.html", "new");
  return staged->commit();
}

std::vector<std::string> all_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    names.push_back(entry.path().lexically_relative(folder));
  std::sort(names.begin(), names.end());
  return names;
}

class FolderInUse : public testing::Test {
 protected:
  void SetUp() override {
    write(root / "result/extrinsics.yaml", "old");
    write(root / "result/overlays/old.jpg", "old");
  }
  ~FolderInUse() override { fs::current_path(stood_in); }

  static void expect_the_new_one(const fs::path& result) {
    EXPECT_THAT(all_in(result), ElementsAre("extrinsics.yaml", "overlays", "overlays/new.jpg", "report.html"));
    EXPECT_EQ(text_of(result / "extrinsics.yaml"), "new");
  }

  const fs::path root = scratch_folder("folder_in_use");
  const fs::path stood_in = fs::current_path();
};

TEST_F(FolderInUse, StaysWhereAProgramStandsInIt) {
  fs::current_path(root / "result");
  ASSERT_TRUE(replace_result("."));
  expect_the_new_one(".");
  EXPECT_THAT(all_in(root), testing::SizeIs(5)) << "something is left beside it";
}

TEST_F(FolderInUse, StaysWhereAProgramStandsBelow) {
  fs::current_path(root / "result/overlays");
  ASSERT_TRUE(replace_result(".."));
  EXPECT_THAT(all_in("."), ElementsAre("new.jpg"));
  expect_the_new_one(root / "result");
}

TEST_F(FolderInUse, ThatIsEmptyIsFilled) {
  fs::remove_all(root / "result");
  fs::create_directory(root / "result");
  fs::current_path(root / "result");
  ASSERT_TRUE(replace_result("."));
  expect_the_new_one(".");
}

TEST_F(FolderInUse, OfALikeNameIsAnother) {
  fs::create_directory(root / "result2");
  fs::current_path(root / "result2");
  EXPECT_FALSE(must_stay(root / "result"));
}

TEST_F(FolderInUse, HasItsFirstEntryOnlyWithAllOthers) {
  fs::current_path(root / "result");
  const int watch = inotify_init1(IN_NONBLOCK);
  ASSERT_GE(watch, 0);
  inotify_add_watch(watch, ".", IN_MOVE);
  ASSERT_TRUE(replace_result("."));
  std::vector<std::string> moves;
  alignas(inotify_event) std::array<char, 4096> bytes{};
  for (ssize_t got = 0; (got = read(watch, bytes.data(), bytes.size())) > 0;) {
    for (ssize_t at = 0; at < got;) {
      const auto* event = reinterpret_cast<const inotify_event*>(bytes.data() + at);
      moves.push_back(((event->mask & IN_MOVED_FROM) != 0 ? "-" : "+") + std::string(event->name));
      at += static_cast<ssize_t>(sizeof(inotify_event) + event->len);
    }
  }
  close(watch);
  EXPECT_THAT(moves, ElementsAre("-extrinsics.yaml", "+report.html", "+extrinsics.yaml"));
}

TEST_F(FolderInUse, IsAsBeforeAfterAnError) {
  const fs::path result = root / "result";
  write(result / "report.html/a folder", "where a file is to come");
  const std::vector<std::string> before = all_in(result);
  fs::current_path(result);
  EXPECT_FALSE(replace_result("."));
  EXPECT_EQ(all_in(result), before);
  EXPECT_EQ(text_of(result / "extrinsics.yaml"), "old");
  EXPECT_EQ(std::distance(fs::directory_iterator(root), {}), 1) << "something is left beside it";
}

TEST_F(FolderInUse, ThatIsMountedIsReplacedWithinItself) {
  const fs::path result = root / "result";
  std::string trouble = "no mount can be made here";
  // Mounts of its own; a thread may have them.
  std::thread([&] {
    if (unshare(CLONE_NEWNS) != 0 || mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return;
    if (mount("none", result.c_str(), "tmpfs", 0, nullptr) != 0) return;
    trouble.clear();
    for (int run = 0; run < 2 && trouble.empty(); ++run) {
      if (const Expected<void> free = StagedFolder::check_place(result); !free) trouble = free.error().message();
      if (const Expected<void> done = replace_result(result); !done) trouble = done.error().message();
    }
    if (trouble.empty()) expect_the_new_one(result);
    umount(result.c_str());
  }).join();
  if (trouble == "no mount can be made here") GTEST_SKIP() << trouble;
  EXPECT_EQ(trouble, "");
}

}  // namespace
}  // namespace rigcal
