#include "core/io/image_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

class ImageFolderTest : public testing::Test {
 protected:
  void file(const std::string& name, const std::string& text = {}) const { std::ofstream(folder_ / name) << text; }

  fs::path folder_ = scratch_folder("image_folder");
};

TEST_F(ImageFolderTest, TakesTheNumbersOfNamesInOrder) {
  for (const char* name : {"10.png", "9.JPG", "0011.jpeg", "x.png", "3.txt", "4.1.png", "99999999999999999999.png"})
    file(name);
  const auto listed = list_image_folder(folder_.string());
  ASSERT_TRUE(listed) << listed.error().message();
  ASSERT_EQ(listed->images.size(), 3U);
  EXPECT_EQ(listed->images[0].number, 9);
  EXPECT_EQ(listed->images[1].number, 10);
  EXPECT_EQ(listed->images[2].number, 11);
  EXPECT_EQ(listed->images[2].path, (folder_ / "0011.jpeg").string());
  EXPECT_FALSE(listed->has_frames);
  EXPECT_THAT(listed->unknown, testing::ElementsAre("3.txt", "4.1.png", "99999999999999999999.png", "x.png"));
}

TEST_F(ImageFolderTest, SaysWhereImagesLieAndHowTheyAreNamedInstead) {
  const auto hint = [&] {
    const auto listed = list_image_folder(folder_.string());
    return listed ? hint_of_unknown(folder_.string(), *listed) : listed.error().message();
  };
  file("x.png");
  EXPECT_EQ(hint(), "");
  file("1700000003.800000.png");
  EXPECT_THAT(hint(), testing::HasSubstr("seconds are not read: name them <stamp_ns>.png"));
  fs::create_directory(folder_ / "data");
  file("data/notes.txt");
  EXPECT_THAT(hint(), testing::HasSubstr("seconds"));
  file("data/1.png");
  file("data/2.JPG");
  EXPECT_EQ(hint(), "its folder data holds 2 images: move them up into " + folder_.string());
}

TEST_F(ImageFolderTest, BelievesFramesRatherThanNames) {
  file("7.png");
  file("8.png");
  file("frames.csv", "file,stamp_ns,trigger,exposure_us,device_stamp,stop\n8.png,2000,,,,\na.png,1000,3,500.5,77,4\n");
  const auto listed = list_image_folder(folder_.string());
  ASSERT_TRUE(listed) << listed.error().message();
  EXPECT_TRUE(listed->has_frames);
  ASSERT_EQ(listed->images.size(), 2U);
  EXPECT_EQ(listed->images[0].path, (folder_ / "a.png").string());
  EXPECT_EQ(listed->images[0].number, 1000);
  EXPECT_EQ(listed->images[0].exposure_us, 500.5);
  EXPECT_EQ(listed->images[0].stop, 4);
  EXPECT_EQ(listed->images[1].number, 2000);
  EXPECT_FALSE(listed->images[1].stop);
  EXPECT_THAT(listed->unknown, testing::ElementsAre("7.png"));
}

TEST_F(ImageFolderTest, RefusesADamagedFramesFileAndAFolderThatIsNotThere) {
  file("frames.csv", "file,stamp_ns\n");
  const auto damaged = list_image_folder(folder_.string());
  ASSERT_FALSE(damaged);
  EXPECT_THAT(damaged.error().message(), testing::HasSubstr("frames.csv:1"));
  EXPECT_FALSE(list_image_folder((folder_ / "none").string()));
}

}  // namespace
}  // namespace rigcal
