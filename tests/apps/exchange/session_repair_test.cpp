#include "apps/exchange/session_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "apps/recording/stop_reader.h"
#include "core/io/frame_files.h"
#include "core/io/session_folder.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void put(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

class SessionRepair : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = scratch_folder("repair");
    sim::RunOptions run = hurried_run(2, 0.8);
    run.images_per_stop = 1;
    simulate_courtyard(small_rig(small_camera("camera", "Mono8")), run, folder / "given");
  }
  static void TearDownTestSuite() { fs::remove_all(folder); }
  void SetUp() override {
    session = folder / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::copy(folder / "given", session, fs::copy_options::recursive);
    auto opened = open_session(session.string());
    ASSERT_TRUE(opened.has_value());
    whole = *opened->record;
    SessionRecord begun;
    begun.software = whole.software;
    begun.start_ns = whole.start_ns;
    ASSERT_TRUE(write_session_record(session.string(), begun).has_value());  // As a running capture leaves it.
  }
  std::vector<std::string> repair() {
    const auto done = repair_session(session.string(), {silent});
    EXPECT_TRUE(done) << done.error().message();
    return done ? *done : std::vector<std::string>{};
  }
  std::size_t stops() {
    const auto source = open_stream(session.string(), {});
    EXPECT_TRUE(source && source->complete);
    NoPoints no_points;
    const auto reading = read_stops(*source, {}, no_points, {silent});
    EXPECT_TRUE(reading && reading->truncation.empty());
    return reading->stops.size();
  }

  static inline fs::path folder;
  fs::path session;
  SessionRecord whole;
  SilentReporter silent;
};

TEST_F(SessionRepair, ASessionWithAnEndIsNotTouched) {
  ASSERT_TRUE(write_session_record(session.string(), whole).has_value());
  const std::string packets = text_of(session / "lidar.pcapng");
  const std::string record = text_of(session / "session.json");
  EXPECT_THAT(repair(), IsEmpty());
  EXPECT_TRUE(packets == text_of(session / "lidar.pcapng"));
  EXPECT_EQ(record, text_of(session / "session.json"));
}

TEST_F(SessionRepair, CutPacketsEndWithTheLastWholeOne) {
  const std::string packets = text_of(session / "lidar.pcapng");
  put(session / "lidar.pcapng", packets.substr(0, packets.size() - 700));
  const auto done = repair();
  ASSERT_EQ(done.size(), 2U);
  EXPECT_THAT(done[0], HasSubstr("lidar.pcapng: "));
  EXPECT_THAT(done[0], HasSubstr("after the last whole packet cut off"));
  EXPECT_EQ(stops(), 2U);
  const auto mended = open_session(session.string());
  ASSERT_TRUE(mended && mended->record && mended->record->end_ns);
  EXPECT_GT(*mended->record->end_ns, whole.start_ns + 2'000'000'000);
  EXPECT_GT(mended->record->counters.at("avia").at("packets"), 1000U);
  EXPECT_THAT(mended->record->gaps, Contains(HasSubstr("cut short here")));
  EXPECT_THAT(repair(), IsEmpty());  // Twice is once.
}

TEST_F(SessionRepair, WithoutItsRecordItGetsOne) {
  fs::remove(session / "session.json");
  EXPECT_THAT(repair(), Contains("session.json: made anew"));
  EXPECT_EQ(stops(), 2U);
}

TEST_F(SessionRepair, TablesAndImagesEndWithWhatIsWhole) {
  const fs::path images = session / "images" / "camera";
  const std::string frames = text_of(images / "frames.csv");
  ASSERT_EQ(read_frames((images / "frames.csv").string())->size(), 2U);
  // The second image came to the disk in part; a third line was being written; a power cut leaves zeros.
  fs::resize_file(images / "000001.png", fs::file_size(images / "000001.png") / 2);
  put(images / "frames.csv", frames + "000002.png,17");
  fs::copy_file(images / "000000.png", images / "000003.png");
  put(session / "trigger.csv", "pulse,stamp_ns\n0,5\n1,7\n" + std::string(40, '\0'));
  put(session / "turntable.csv", "stamp_ns,angle_deg\n5,0\n7,18.0\n9,");
  EXPECT_THAT(repair(), ElementsAre("trigger.csv: 40 bytes of unfinished lines cut off",
                                    "turntable.csv: 2 bytes of unfinished lines cut off",
                                    "images/camera/frames.csv: 13 bytes of unfinished lines cut off",
                                    "camera: 1 image that had not reached the disk taken out of frames.csv",
                                    "camera: 2 images without a line in frames.csv left aside",
                                    HasSubstr("session.json: its end")));
  EXPECT_EQ(read_frames((images / "frames.csv").string())->size(), 1U);
  EXPECT_EQ(read_trigger((session / "trigger.csv").string())->size(), 2U);
  EXPECT_EQ(read_turntable((session / "turntable.csv").string())->size(), 2U);
}

TEST_F(SessionRepair, TablesThatAreDamagedInTheMiddleAreLeftToTheUser) {
  std::string lines = "stamp_ns,angle_deg\n5,0\n7,x\n";
  for (int i = 0; i < 1000; ++i) lines += std::to_string(10 + i) + ",1\n";
  put(session / "turntable.csv", lines);
  auto done = repair_session(session.string(), {silent});
  ASSERT_FALSE(done);
  EXPECT_THAT(done.error().message(), HasSubstr("turntable.csv:3: angle_deg is 'x'"));
  EXPECT_THAT(done.error().message(), HasSubstr("mend the line by hand"));
  EXPECT_EQ(text_of(session / "turntable.csv"), lines);
  put(session / "turntable.csv", "angle_deg,stamp_ns\n" + lines.substr(19, 200));
  done = repair_session(session.string(), {silent});
  ASSERT_FALSE(done) << "nothing would be left";
  EXPECT_THAT(done.error().message(), HasSubstr("turntable.csv:1: the first line is not the header"));
  // Of these nothing is lost, however long they are.
  put(session / "turntable.csv", "stamp_ns,angle_deg\n5,0\n7,1" + std::string(100'000, '\0'));
  put(session / "trigger.csv", "");
  EXPECT_THAT(repair(), testing::IsSupersetOf({"trigger.csv: held no whole line and is gone",
                                               "turntable.csv: 100003 bytes of unfinished lines cut off"}));
}

TEST_F(SessionRepair, ANewestPartWithNothingWholeIsTakenAway) {
  // As `capture --keep` leaves it where the power fails when a part has just begun.
  fs::rename(session / "lidar.pcapng", session / "lidar.000001.pcapng");
  const std::string part = text_of(session / "lidar.000001.pcapng");
  put(session / "lidar.pcapng", part.substr(0, 20));
  EXPECT_THAT(repair(), Contains("lidar.pcapng: held nothing whole and is gone"));
  EXPECT_FALSE(fs::exists(session / "lidar.pcapng"));
  EXPECT_EQ(stops(), 2U);
}

TEST_F(SessionRepair, AnyCutGivesASessionThatCanBeRead) {
  const std::string packets = text_of(session / "lidar.pcapng");
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{30}, std::size_t{100}, packets.size() / 3,
                                 packets.size() / 2 + 1, packets.size() - 1}) {
    put(session / "lidar.pcapng", packets.substr(0, size));
    SessionRecord begun;
    begun.start_ns = whole.start_ns;
    ASSERT_TRUE(write_session_record(session.string(), begun).has_value());
    const auto done = repair_session(session.string(), {silent});
    if (size < 76) continue;  // Not even the file's head: nothing to be had, and it says so or is gone.
    ASSERT_TRUE(done) << size << ": " << done.error().message();
    const auto source = open_stream(session.string(), {});
    ASSERT_TRUE(source && source->complete) << size;
    NoPoints no_points;
    EXPECT_TRUE(read_stops(*source, {}, no_points, {silent}).has_value()) << size;
  }
}

TEST_F(SessionRepair, WhatIsNoSessionIsRefused) {
  EXPECT_FALSE(repair_session((folder / "nothing").string(), {silent}).has_value());
  EXPECT_FALSE(repair_session(folder.string(), {silent}).has_value());
}

}  // namespace
}  // namespace rigcal
