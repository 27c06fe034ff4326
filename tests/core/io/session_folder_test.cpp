#include "core/io/session_folder.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

#include "core/io/output_file.h"
#include "tests/core/io/dump_bytes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

Rig small_rig() {
  return *parse_rig("rigcal: 1\nbase: a\nsensors:\n  a: {type: livox_avia, ip: 10.0.0.1}\n  b: {type: livox_mid40}\n",
                    "rig.yaml");
}

std::string new_session(const std::string& name) {
  const std::string path = fresh_path(name);
  SessionRecord record;
  record.software = "0.1.0";
  record.start_ns = 1'700'000'000'000'000'001;
  const Expected<void> created = create_session(path, small_rig(), record);
  EXPECT_TRUE(created) << created.error().message();
  return path;
}

void put(const std::string& path, const std::string& text) { std::ofstream(path) << text; }

TEST(SessionFolder, HoldsWhatWasWrittenIntoIt) {
  const std::string path = new_session("session");
  put(session_packets_path(path), "x");
  put(path + "/ground_truth.yaml", "x");
  SessionRecord record;
  record.software = "0.1.0";
  record.start_ns = 1'700'000'000'000'000'001;
  record.end_ns = 1'700'000'060'000'000'003;
  record.clock_pairs = {{5, 6}, {7, 8}};
  record.counters["a"]["packets"] = 18'446'744'073'709'551'615U;
  record.gaps = {"b: 3 packets were lost"};
  record.events = {"b: connected"};
  ASSERT_TRUE(write_session_record(path, record));

  const Expected<SessionFolder> session = open_session(path);
  ASSERT_TRUE(session) << session.error().message();
  EXPECT_EQ(session->rig.sensors.size(), 2U);
  EXPECT_EQ(session->record->start_ns, record.start_ns);
  EXPECT_EQ(session->record->end_ns, record.end_ns);
  EXPECT_EQ(session->record->clock_pairs[1].monotonic_ns, 8);
  EXPECT_EQ(session->record->counters, record.counters);
  EXPECT_EQ(session->record->gaps, record.gaps);
  EXPECT_EQ(session->record->events, record.events);
  EXPECT_EQ(session->packets, session_packets_path(path));
  EXPECT_EQ(session->ground_truth, path + "/ground_truth.yaml");
  EXPECT_EQ(session->patches, "");
}

TEST(SessionFolder, HasNoEndUntilItIsFinished) {
  const std::string path = new_session("unfinished");
  put(session_packets_path(path), "x");
  const Expected<SessionFolder> session = open_session(path);
  ASSERT_TRUE(session);
  EXPECT_FALSE(session->record->end_ns);
}

TEST(SessionFolder, IsReadableWithoutItsRecord) {
  const std::string path = new_session("no_record");
  put(session_packets_path(path), "x");
  std::filesystem::remove(path + "/session.json");
  const Expected<SessionFolder> session = open_session(path);
  ASSERT_TRUE(session);
  EXPECT_FALSE(session->record);
}

TEST(SessionFolder, IsNeverOverwritten) {
  const std::string path = new_session("twice");
  const Expected<void> again = create_session(path, small_rig(), {});
  ASSERT_FALSE(again);
  EXPECT_THAT(again.error().message(), HasSubstr("exists already"));
  const std::string file = write_text("a_file", "keep me");
  EXPECT_FALSE(create_session(file, small_rig(), {}));
  EXPECT_EQ(read_bytes(file).size(), 7U);
}

TEST(SessionFolder, SaysWhatIsWrong) {
  const auto message = [](const std::string& path) {
    const Expected<SessionFolder> session = open_session(path);
    return session ? std::string("no error") : session.error().message();
  };
  EXPECT_THAT(message(fresh_path("nowhere")), HasSubstr("no such file"));
  EXPECT_THAT(message(write_text("file", "x")), HasSubstr("no session folder"));
  EXPECT_THAT(message(scratch_folder("no_session")), HasSubstr("no rig.yaml"));
  const std::string path = new_session("bare");
  EXPECT_THAT(message(path), HasSubstr("neither lidar.pcapng nor patches"));
  put(session_packets_path(path), "x");
  put(path + "/session.json", "{\"format\": 2}");
  EXPECT_THAT(message(path), HasSubstr("reads format 1; use rigcal 2.0"));
  put(path + "/session.json", "{\"format\": 1");
  EXPECT_THAT(message(path), HasSubstr("no valid JSON"));
  put(path + "/session.json", "{\"format\": 1, \"start_ns\": \"now\"}");
  EXPECT_THAT(message(path), HasSubstr("'start_ns'"));
  put(path + "/session.json", "{\"format\": 1, \"start_ns\": 5, \"end_ns\": 4}");
  EXPECT_THAT(message(path), HasSubstr("session.json: 'end_ns' lies before 'start_ns'; restore the file"));
  put(path + "/session.json", "[1]");
  EXPECT_THAT(message(path), HasSubstr("'format'"));
}

TEST(SessionFolder, PartsPastAMillionComeInOrder) {
  const std::string path = new_session("parts");
  const std::string newest = session_packets_path(path);
  std::vector<std::string> parts;
  for (const int number : {999'998, 999'999, 1'000'000, 1'000'001, 10'000'000})
    parts.push_back(session_packets_part_path(newest, number));
  EXPECT_THAT(parts[2], HasSubstr("lidar.1000000.pcapng"));
  for (const std::string& part : parts) put(part, "x");
  for (const char* other : {"/lidar.00001.pcapng", "/lidar.000001x.pcapng", "/lidar.-000001.pcapng"})
    put(path + other, "x");
  EXPECT_EQ(session_packet_parts(newest), parts);
  EXPECT_EQ(open_session(path)->packets, newest) << "the newest has not begun yet";
  put(newest, "x");
  parts.push_back(newest);
  EXPECT_EQ(session_packet_parts(newest), parts);
}

TEST(SessionFolder, WithoutItsRigIsStillOne) {
  const std::string path = new_session("no_rig");
  put(session_packets_path(path), "x");
  std::filesystem::remove(path + "/rig.yaml");
  EXPECT_TRUE(is_session_folder(path));
  EXPECT_THAT(open_session(path).error().message(), HasSubstr("has no rig.yaml"));
  EXPECT_THAT(open_session(path).error().message(), HasSubstr("put it back"));
}

TEST(SessionFolder, ThatMayNotBeReadSaysSo) {
  const std::string path = new_session("closed");
  put(session_packets_path(path), "x");
  std::filesystem::permissions(path, std::filesystem::perms::none);
  // Nothing is closed to root.
  const uid_t user = geteuid();
  const bool changed = user == 0 && seteuid(65534) == 0;
  const bool is_session = is_session_folder(path);
  const Expected<SessionFolder> session = open_session(path);
  if (changed) {
    ASSERT_EQ(seteuid(user), 0);
  }
  std::filesystem::permissions(path, std::filesystem::perms::owner_all);
  if (user == 0 && !changed) GTEST_SKIP() << "cannot be anybody but root here";
  EXPECT_TRUE(is_session);
  ASSERT_FALSE(session);
  EXPECT_THAT(session.error().message(), HasSubstr("no permission to read it"));
}

TEST(ReplaceFile, LeavesNothingBesideTheFile) {
  const std::string folder = fresh_path("replace");
  std::filesystem::create_directory(folder);
  ASSERT_TRUE(replace_file(folder + "/a.txt", "old"));
  ASSERT_TRUE(replace_file(folder + "/a.txt", "new"));
  const Bytes bytes = read_bytes(folder + "/a.txt");
  EXPECT_EQ(std::string(bytes.begin(), bytes.end()), "new");
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 1);
  EXPECT_FALSE(replace_file(folder + "/none/a.txt", "x"));
}

}  // namespace
}  // namespace rigcal
