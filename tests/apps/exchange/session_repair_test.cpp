#include "apps/exchange/session_repair.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>

#include "apps/recording/stop_reader.h"
#include "core/io/capture_file.h"
#include "core/io/frame_files.h"
#include "core/io/session_folder.h"
#include "core/io/session_lock.h"
#include "tests/support/broken_reads.h"
#include "tests/support/files.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

void put(const fs::path& path, const std::string& text) { std::ofstream(path, std::ios::binary) << text; }

/// Where a block of a packet file begins that lies behind its first `from` bytes.
std::size_t block_behind(const fs::path& path, std::size_t from) {
  Expected<CaptureFile> file = CaptureFile::open(path.string());
  CapturedFrame frame;
  while (file && file->whole_bytes() < from && file->next(frame)) {
  }
  return file ? file->whole_bytes() : 0;
}

/// The same packets, but for one whose length is nonsense.
std::string damaged_at(std::string packets, std::size_t block) {
  return packets.replace(block + 4, 4, std::string("\7\0\0\0", 4));
}

/// Does something each time that it is told how far the work is.
class MeddlingReporter final : public Reporter {
 public:
  explicit MeddlingReporter(std::function<void()> meddle) : meddle_(std::move(meddle)) {}
  void progress(std::string_view, double) override { meddle_(); }
  void warn(std::string) override {}
  void debug(std::string) override {}

 private:
  std::function<void()> meddle_;
};

class SessionRepair : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = scratch_folder("repair");
    sim::RunOptions run = hurried_run(2, 0.8);
    run.images_per_stop = 1;
    simulate_courtyard(small_rig(small_camera("camera", "Mono8")), run, folder / "given");
  }
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
  void begin_anew() {
    SessionRecord begun;
    begun.start_ns = whole.start_ns;
    ASSERT_TRUE(write_session_record(session.string(), begun).has_value());
  }
  Error refusal(Reporter& reporter) {
    const auto done = repair_session(session.string(), {reporter});
    EXPECT_FALSE(done);
    return done ? Error{} : done.error();
  }
  std::vector<std::string> files() {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(session)) names.push_back(entry.path().filename().string());
    return names;
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

TEST_F(SessionRepair, WhatFollowsDamageFarFromTheEndIsKeptBesideTheFile) {
  const fs::path packets = session / "lidar.pcapng";
  const std::string given = text_of(packets);
  const std::size_t block = block_behind(packets, given.size() / 3);
  ASSERT_GT(given.size() - block, std::size_t{2} << 20U) << "more than what may be thrown away";
  const std::string damaged = damaged_at(given, block);
  put(packets, damaged);
  const std::string sentence = "lidar.pcapng: at byte " + std::to_string(block) +
                               " a block has the length 7, far before its end; the " +
                               std::to_string(given.size() - block) + " bytes from there on are now in ";
  EXPECT_THAT(repair(), ElementsAre(sentence + "lidar.pcapng.tail", HasSubstr("session.json: its end")));
  EXPECT_TRUE(text_of(packets) == damaged.substr(0, block));
  EXPECT_TRUE(text_of(session / "lidar.pcapng.tail") == damaged.substr(block));
  EXPECT_THAT(session_packet_parts(packets.string()), ElementsAre(packets.string())) << "nobody reads it";
  EXPECT_THAT(open_session(session.string())->record->gaps, Contains(sentence + "lidar.pcapng.tail"));
  EXPECT_THAT(repair(), IsEmpty());
  // The tail of another time is not touched.
  begin_anew();
  put(packets, damaged);
  EXPECT_THAT(repair(), Contains(sentence + "lidar.pcapng.tail2"));
  EXPECT_TRUE(text_of(session / "lidar.pcapng.tail") == damaged.substr(block));
  EXPECT_TRUE(text_of(session / "lidar.pcapng.tail2") == damaged.substr(block));
  // Zeros are what a power cut leaves: of these nothing is lost, however many they are.
  begin_anew();
  put(packets, given.substr(0, block) + std::string(given.size() - block, '\0'));
  EXPECT_THAT(repair(), Contains(HasSubstr(" bytes after the last whole packet cut off")));
  EXPECT_TRUE(text_of(packets) == given.substr(0, block));
  EXPECT_FALSE(fs::exists(session / "lidar.pcapng.tail3"));
}

TEST_F(SessionRepair, WithoutRoomForWhatMustBeKeptNothingIsTouched) {
  const fs::path packets = session / "lidar.pcapng";
  const std::string given = text_of(packets);
  const std::string damaged = damaged_at(given, block_behind(packets, given.size() / 3));
  const auto before = files();
  // It runs out while it is written.
  put(packets, damaged);
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  const rlimit small{1U << 20U, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const Error stopped = refusal(silent);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(stopped.kind, ErrorKind::system);
  EXPECT_TRUE(text_of(packets) == damaged);
  EXPECT_THAT(files(), testing::UnorderedElementsAreArray(before));
  EXPECT_TRUE(is_unfinished_session(session.string()));
  // It is known not to be there.
  std::error_code error;
  fs::resize_file(packets, std::uintmax_t{1} << 43U, error);
  if (error || fs::space(session).available >= std::uintmax_t{1} << 43U) GTEST_SKIP() << "no such long file here";
  EXPECT_THAT(refusal(silent).message(), HasSubstr("the disk has no room for the 87960"));
  EXPECT_EQ(fs::file_size(packets), std::uintmax_t{1} << 43U);
  EXPECT_THAT(files(), testing::UnorderedElementsAreArray(before));
}

TEST_F(SessionRepair, AReadThatFailsEndsItAndNothingIsTouched) {
  // The file that can be read is torn, and cut only once all others are known to be readable.
  const std::string given = text_of(session / "lidar.pcapng");
  ASSERT_GT(given.size(), std::size_t{2} << 20U) << "more than what is read ahead";
  put(session / "lidar.000001.pcapng", given.substr(0, given.size() - 700));
  MeddlingReporter breaking([this] { break_reads(session / "lidar.pcapng"); });
  const Error failed = refusal(breaking);
  EXPECT_EQ(failed.kind, ErrorKind::system);
  EXPECT_THAT(failed.message(), HasSubstr("lidar.pcapng: cannot be read to its end (Is a directory)"));
  EXPECT_TRUE(text_of(session / "lidar.pcapng") == given);
  EXPECT_EQ(fs::file_size(session / "lidar.000001.pcapng"), given.size() - 700);
  EXPECT_TRUE(is_unfinished_session(session.string()));
}

TEST_F(SessionRepair, ASessionThatIsStillBeingRecordedIsNotTouched) {
  const std::string given = text_of(session / "lidar.pcapng");
  const std::string torn = given.substr(0, given.size() - 700);
  put(session / "lidar.pcapng", torn);
  {
    const auto capture = SessionLock::take(session.string());
    ASSERT_TRUE(capture);
    const Error refused = refusal(silent);
    EXPECT_EQ(refused.kind, ErrorKind::system);
    EXPECT_THAT(refused.message(), HasSubstr("is still being recorded"));
    EXPECT_TRUE(text_of(session / "lidar.pcapng") == torn);
    EXPECT_TRUE(is_unfinished_session(session.string()));
    ASSERT_TRUE(write_session_record(session.string(), whole).has_value());
    EXPECT_THAT(repair(), IsEmpty()) << "it has its end already";
    begin_anew();
  }
  // On another machine, whose lock is not seen.
  MeddlingReporter growing([&] { std::ofstream(session / "lidar.pcapng", std::ios::app) << "more"; });
  EXPECT_THAT(refusal(growing).message(), HasSubstr("lidar.pcapng: grew while it was read"));
  EXPECT_GT(fs::file_size(session / "lidar.pcapng"), torn.size());
  EXPECT_EQ(repair().size(), 2U);
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

TEST_F(SessionRepair, AnImageThatCannotBeLookedAtStaysInItsTable) {
  const fs::path images = session / "images" / "camera";
  const std::string frames = text_of(images / "frames.csv");
  const std::string packets = text_of(session / "lidar.pcapng");
  put(session / "lidar.pcapng", packets.substr(0, packets.size() - 700));
  fs::remove(images / "000001.png");
  fs::create_symlink("000001.png", images / "000001.png");  // It leads to itself.
  NotingReporter noting;
  EXPECT_THAT(refusal(noting).message(), HasSubstr("000001.png: cannot be read"));
  EXPECT_EQ(text_of(images / "frames.csv"), frames);
  EXPECT_THAT(noting.warnings, ElementsAre(HasSubstr("after the last whole packet cut off"))) << "it is done";
  // One that is there and may not be read is no shorter for that; a folder stands for it, as root may read all.
  fs::remove(images / "000001.png");
  fs::create_directory(images / "000001.png");
  EXPECT_THAT(refusal(silent).message(), HasSubstr("000001.png: is a folder"));
  EXPECT_EQ(text_of(images / "frames.csv"), frames);
  fs::remove(images / "000001.png");
  EXPECT_THAT(repair(), Contains("camera: 1 image that had not reached the disk taken out of frames.csv"));
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

TEST_F(SessionRepair, ANewestPartWhoseHeadIsDamagedIsKeptByAnotherName) {
  fs::rename(session / "lidar.pcapng", session / "lidar.000001.pcapng");
  const std::string part = damaged_at(text_of(session / "lidar.000001.pcapng"), 0);
  put(session / "lidar.pcapng", part);
  EXPECT_THAT(repair(), Contains(HasSubstr("nothing whole is left in it; it is now lidar.pcapng.tail")));
  EXPECT_FALSE(fs::exists(session / "lidar.pcapng"));
  EXPECT_TRUE(text_of(session / "lidar.pcapng.tail") == part);
  EXPECT_EQ(stops(), 2U);
}

TEST_F(SessionRepair, ANewestPartOfWhichAPowerCutLeftZerosIsTakenAway) {
  fs::rename(session / "lidar.pcapng", session / "lidar.000001.pcapng");
  put(session / "lidar.pcapng", std::string(1 << 20, '\0'));
  EXPECT_THAT(repair(), Contains("lidar.pcapng: held nothing whole and is gone"));
  EXPECT_FALSE(fs::exists(session / "lidar.pcapng"));
  EXPECT_EQ(stops(), 2U);
}

TEST_F(SessionRepair, ANewestPartWithoutItsHeadIsKeptByAnotherName) {
  fs::rename(session / "lidar.pcapng", session / "lidar.000001.pcapng");
  std::string part = text_of(session / "lidar.000001.pcapng");
  part.replace(0, 4096, std::string(4096, '\0'));
  put(session / "lidar.pcapng", part);
  EXPECT_THAT(repair(), Contains(HasSubstr("its head is gone, so that nothing whole is left in it; it is now "
                                           "lidar.pcapng.tail")));
  EXPECT_TRUE(text_of(session / "lidar.pcapng.tail") == part);
  begin_anew();
  put(session / "lidar.pcapng", "no packets, but notes of somebody");
  EXPECT_THAT(refusal(silent).message(), HasSubstr("is no packet dump"));
  EXPECT_TRUE(fs::exists(session / "lidar.pcapng"));
}

TEST_F(SessionRepair, SaysWhatIsLeftWhereNoPacketIs) {
  put(session / "lidar.pcapng", "");
  NotingReporter notes;
  EXPECT_THAT(
      refusal(notes).message(),
      HasSubstr("no packet of its LiDARs had reached the disk whole; its rig file, tables and images are left"));
  EXPECT_THAT(notes.warnings, Contains("lidar.pcapng: was empty and is gone"));
  EXPECT_TRUE(fs::exists(session / "rig.yaml"));
}

TEST_F(SessionRepair, AnyCutGivesASessionThatCanBeRead) {
  const std::string packets = text_of(session / "lidar.pcapng");
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{30}, std::size_t{100}, packets.size() / 3,
                                 packets.size() / 2 + 1, packets.size() - 1}) {
    put(session / "lidar.pcapng", packets.substr(0, size));
    begin_anew();
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
