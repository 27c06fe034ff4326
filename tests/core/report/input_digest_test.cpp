#include "core/report/input_digest.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/files_below.h"
#include "tests/support/run_program.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

class InputDigests : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(root / "session/patches/avia");
    write("session/rig.yaml", "rigcal: 1\n");
    write("session/patches/avia/0.pcd", "first");
    write("session/patches/avia/1.pcd", std::string(3'000'000, 'x'));
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(root / name) << text; }
  // What sha256sum says, run in a folder of the test.
  [[nodiscard]] std::string said(const std::string& command) const {
    return run_program("cd '" + (root / "session").string() + "' && " + command, root).out.substr(0, 64);
  }

  fs::path root = scratch_folder("input_digest");
};

TEST_F(InputDigests, AreThoseThatSha256sumGives) {
  const auto found = digest_inputs({(root / "session").string(), (root / "not there").string()}, {});
  ASSERT_EQ(found.size(), 2U);
  EXPECT_EQ(found[0].path, (root / "session/patches/").string());
  EXPECT_EQ(found[0].files, 2U);
  EXPECT_EQ(found[0].bytes, 3'000'005U);
  EXPECT_EQ(found[0].sha256,
            said("cd patches && find -L . -type f -print0 | LC_ALL=C sort -z | xargs -0 sha256sum | sha256sum"));
  EXPECT_EQ(found[1].path, (root / "session/rig.yaml").string());
  EXPECT_EQ(found[1].sha256, said("sha256sum rig.yaml"));
  EXPECT_FALSE(found[1].in_part);
}

TEST_F(InputDigests, FollowLinksAndNoneOfThemInACircle) {
  fs::create_directories(root / "disk");
  write("disk/0.pcd", "behind a link");
  fs::create_directory_symlink(root / "disk", root / "session/patches/mid");
  fs::create_directory_symlink(root / "session/patches", root / "disk/back");
  const auto digest = [&] { return digest_inputs({(root / "session").string()}, {}).at(0); };
  const InputDigest before = digest();
  EXPECT_EQ(before.files, 3U);
  EXPECT_EQ(files_below(root / "session/patches")->back(), "mid/0.pcd");
  write("disk/0.pcd", "behind a Link");
  EXPECT_NE(digest().sha256, before.sha256);
  EXPECT_FALSE(files_below(root / "not there"));
}

TEST_F(InputDigests, OfLargeFilesSeeSizeAndBothEnds) {
  const std::string path = (root / "session/patches/avia/1.pcd").string();
  const auto digest = [&] { return digest_inputs({path}, {}, 1000).at(0); };
  const InputDigest first = digest();
  EXPECT_TRUE(first.in_part);
  EXPECT_EQ(first.bytes, 3'000'000U);
  EXPECT_NE(first.sha256, digest_inputs({path}, {}).at(0).sha256);
  std::string text(3'000'000, 'x');
  for (const std::size_t at : {std::size_t{0}, text.size() - 1}) {
    text[at] = 'y';
    write("session/patches/avia/1.pcd", text);
    EXPECT_NE(digest().sha256, first.sha256) << at;
    text[at] = 'x';
  }
  write("session/patches/avia/1.pcd", text + "x");
  EXPECT_NE(digest().sha256, first.sha256);
}

TEST_F(InputDigests, EndEarlyWhenTold) {
  std::stop_source stop;
  stop.request_stop();
  EXPECT_TRUE(digest_inputs({(root / "session").string()}, stop.get_token()).empty());
}

}  // namespace
}  // namespace rigcal
