#include "core/io/recorded_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "core/io/image_folder.h"
#include "core/io/session_folder.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

class RecordedTableTest : public testing::Test {
 protected:
  void put(const std::string& text) const { std::ofstream(table_path()) << text; }
  [[nodiscard]] std::string table_path() const { return (session_ / "turntable.csv").string(); }
  [[nodiscard]] RecordedTable read() const {
    const auto table = read_recorded_table(table_path(), session_.string());
    EXPECT_TRUE(table) << table.error().message();
    return table ? *table : RecordedTable{};
  }
  void record(std::optional<std::int64_t> end_ns) const {
    SessionRecord record;
    record.end_ns = end_ns;
    ASSERT_TRUE(write_session_record(session_.string(), record));
  }

  fs::path session_ = scratch_folder("recorded_table");
};

TEST_F(RecordedTableTest, OfAnUnfinishedSessionItEndsWithItsLastWholeLine) {
  record(std::nullopt);
  put("a,b\n5,0\n7,180");  // The beginning of 180.25, perhaps.
  EXPECT_EQ(read().text, "a,b\n5,0\n");
  EXPECT_THAT(read().torn, HasSubstr("turntable.csv: its last line is not whole"));
  put("a,");
  EXPECT_EQ(read().text, "");
  put("a,b\n5,0\n");
  EXPECT_EQ(read().text, "a,b\n5,0\n");
  EXPECT_EQ(read().torn, "");
}

TEST_F(RecordedTableTest, OfAnyOtherTheLastLineNeedsNoNewline) {
  put("a,b\n5,0\n7,180");
  EXPECT_EQ(read().text, "a,b\n5,0\n7,180");
  record(7);
  EXPECT_EQ(read().text, "a,b\n5,0\n7,180");
  EXPECT_EQ(read().torn, "");
}

TEST_F(RecordedTableTest, ZerosAtItsEndAreNoLine) {
  const std::string zeros(5000, '\0');
  for (const std::string& tail : {zeros, "7,18" + zeros, zeros + "\n"}) {
    put("a,b\n5,0\n" + tail);
    EXPECT_EQ(read().text, "a,b\n5,0\n");
    EXPECT_NE(read().torn, "");
  }
  put(zeros);
  EXPECT_EQ(read().text, "");
  put("a,b\n" + zeros + "\n5,0\n");  // In the middle they are damage, which the parser names.
  EXPECT_EQ(read().torn, "");
}

TEST_F(RecordedTableTest, ACameraKeepsItsImagesWhereTheLastLineIsTorn) {
  record(std::nullopt);
  const fs::path camera = session_ / "images" / "left";
  fs::create_directories(camera);
  std::ofstream(camera / "frames.csv") << "file,stamp_ns,trigger,exposure_us,device_stamp,stop\na.png,5,,,,\nb.png,7";
  for (const std::string& path : {camera.string(), camera.string() + "/"}) {
    const auto listed = list_image_folder(path);
    ASSERT_TRUE(listed) << listed.error().message();
    EXPECT_EQ(listed->images.size(), 1U);
    EXPECT_THAT(listed->torn, HasSubstr("frames.csv: its last line is not whole"));
  }
}

}  // namespace
}  // namespace rigcal
