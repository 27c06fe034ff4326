// What `rigcal batch` is made of: names, claims, memory, and what it keeps.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "apps/batch/batch_table.h"
#include "apps/batch/memory_budget.h"
#include "apps/batch/session_claim.h"
#include "apps/batch/session_names.h"
#include "apps/batch/session_record.h"
#include "core/base/version.h"
#include "tests/support/json.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::batch {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;

std::vector<std::string> names_of(const std::vector<std::string>& inputs) {
  const auto sessions = name_sessions(inputs);
  EXPECT_TRUE(sessions) << sessions.error().message();
  std::vector<std::string> names;
  if (!sessions) return names;
  for (const Session& session : *sessions) names.push_back(session.name);
  return names;
}

TEST(SessionNames, AreTheLastPartAndMoreWhereThatIsShared) {
  EXPECT_THAT(names_of({"fleet/car7", "/data/car8/", "run.pcap"}), ElementsAre("car7", "car8", "run.pcap"));
  EXPECT_THAT(names_of({"fleet/car7/session", "fleet/car8/session", "fleet/car9/run"}),
              ElementsAre("car7_session", "car8_session", "run"));
  EXPECT_THAT(names_of({"/a/.hidden"}), ElementsAre("_hidden")) << "the batch's own files begin with a dot";
  EXPECT_THAT(names_of({"/a/x/../y"}), ElementsAre("y"));
}

TEST(SessionNames, RefuseWhatCannotBeToldApart) {
  EXPECT_THAT(name_sessions({}).error().message(), HasSubstr("no recording is given"));
  EXPECT_THAT(name_sessions({"a/b", "./a/b/"}).error().message(), HasSubstr("given twice"));
  EXPECT_THAT(name_sessions({"/a_b/c", "/a/b_c", "/b_c", "/c"}).error().message(),
              HasSubstr("would be called \"a_b_c\""));
}

class BatchFiles : public testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    fs::create_directories((scratch / name).parent_path());
    std::ofstream(scratch / name) << text;
  }
  [[nodiscard]] std::string path(const std::string& name) const { return (scratch / name).string(); }

  fs::path scratch = scratch_folder("batch_parts");
};

TEST_F(BatchFiles, ListsHaveAPathALine) {
  write("list", "one\n\n# not this\nwith a space\r\n");
  const auto listed = read_list(path("list"));
  ASSERT_TRUE(listed) << listed.error().message();
  EXPECT_THAT(*listed, ElementsAre("one", "with a space"));
  EXPECT_THAT(read_list(path("none")).error().message(), HasSubstr("none: cannot read the list"));
  EXPECT_THAT(read_list(path("none")).error().message(), HasSubstr("; check its name"));
}

TEST_F(BatchFiles, AClaimIsHadByOneUntilItEnds) {
  auto first = SessionClaim::take(path("a.claim"));
  ASSERT_TRUE(first && *first);
  const auto second = SessionClaim::take(path("a.claim"));
  ASSERT_TRUE(second);
  EXPECT_FALSE(second->has_value());
  EXPECT_TRUE(SessionClaim::take(path("b.claim"))->has_value());
  first->reset();
  EXPECT_TRUE(SessionClaim::take(path("a.claim"))->has_value());
  EXPECT_FALSE(SessionClaim::take(path("no folder/a.claim")));
}

TEST(MemoryBudget, CountsTheLargestPeakSeenForEach) {
  constexpr std::uint64_t gib = std::uint64_t{1} << 30U;
  MemoryBudget memory(6 * gib);
  EXPECT_TRUE(memory.fits(2)) << "2 GiB each before any is known";
  EXPECT_FALSE(memory.fits(3));
  memory.saw_peak(512.0);
  memory.saw_peak(256.0);
  EXPECT_TRUE(memory.fits(11));
  EXPECT_FALSE(memory.fits(12));
  memory.saw_peak(9000.0);
  EXPECT_TRUE(memory.fits(0)) << "one is always tried";
  EXPECT_FALSE(memory.fits(1));
  EXPECT_GT(available_memory().value_or(0), gib / 8);
}

class AvailableMemory : public BatchFiles {
 protected:
  static constexpr std::uint64_t gib = std::uint64_t{1} << 30U;

  void SetUp() override {
    BatchFiles::SetUp();
    write("proc/meminfo", "MemTotal:       134217728 kB\nMemFree: 7 kB\nMemAvailable:   104857600 kB\n");
  }
  /// Of the process; `lines` as in /proc/self/cgroup.
  void is_in(const std::string& lines) const { write("proc/self/cgroup", lines); }
  void group(const std::string& name, const std::string& limit, std::uint64_t use, std::uint64_t cache = 0) const {
    write("groups/" + name + "/memory.max", limit + "\n");
    write("groups/" + name + "/memory.current", std::to_string(use) + "\n");
    write("groups/" + name + "/memory.stat", "anon 5\ninactive_file " + std::to_string(cache) + "\nactive_file 77\n");
  }
  void old_group(const std::string& name, std::uint64_t limit, std::uint64_t use, std::uint64_t cache = 0) const {
    write("groups/memory/" + name + "/memory.limit_in_bytes", std::to_string(limit) + "\n");
    write("groups/memory/" + name + "/memory.usage_in_bytes", std::to_string(use) + "\n");
    write("groups/memory/" + name + "/memory.stat",
          "cache 1\ninactive_file 0\ntotal_cache 9\ntotal_inactive_file " + std::to_string(cache) + "\n");
  }
  /// In GiB; -1: not known.
  [[nodiscard]] double available() const {
    const auto bytes = available_memory(path("proc"), path("groups"));
    return bytes ? static_cast<double>(*bytes) / static_cast<double>(gib) : -1.0;
  }
};

TEST_F(AvailableMemory, IsTheMachinesWhereNoGroupHasALimit) {
  EXPECT_EQ(available(), 100.0) << "no groups at all";
  is_in("0::/user.slice/session\n");
  group("user.slice/session", "max", 3 * gib);
  EXPECT_EQ(available(), 100.0);
  group("user.slice/session", std::to_string(200 * gib), 3 * gib);
  EXPECT_EQ(available(), 100.0) << "more than there is";
  fs::remove(scratch / "proc/meminfo");
  EXPECT_EQ(available(), 197.0);
  fs::remove_all(scratch / "groups");
  EXPECT_EQ(available(), -1.0);
}

TEST_F(AvailableMemory, IsBoundByEachGroupAbove) {
  // As a scheduler sets them: a process is in the group of its task, which has no limit of its own.
  is_in("0::/slurm/job_7/step_0/task_0\n");
  group("slurm/job_7/step_0/task_0", "max", gib);
  group("slurm/job_7/step_0", std::to_string(16 * gib), gib);
  group("slurm/job_7", std::to_string(8 * gib), 3 * gib);
  EXPECT_EQ(available(), 5.0);
  group("slurm/job_7/step_0", std::to_string(4 * gib), gib);
  EXPECT_EQ(available(), 3.0);
  group("slurm/job_7/step_0/task_0", std::to_string(2 * gib), gib);
  EXPECT_EQ(available(), 1.0);
}

TEST_F(AvailableMemory, HasRoomWhereFilesAreOnlyRemembered) {
  is_in("0::/job\n");
  group("job", std::to_string(8 * gib), 8 * gib, 6 * gib);
  EXPECT_EQ(available(), 6.0);
  group("job", std::to_string(8 * gib), 3 * gib, 5 * gib);  // Read one after the other.
  EXPECT_EQ(available(), 8.0);
}

TEST_F(AvailableMemory, IsNoneWhereAllOfALimitIsUsed) {
  is_in("0::/job\n");
  group("job", std::to_string(8 * gib), 8 * gib);
  EXPECT_EQ(available(), 0.0);
  group("job", std::to_string(8 * gib), 9 * gib, gib / 2);
  EXPECT_EQ(available(), 0.0);
  group("job", "0", 0);
  EXPECT_EQ(available(), 0.0) << "a limit of nothing is one";
}

TEST_F(AvailableMemory, KnowsTheGroupsOfTheFirstVersion) {
  constexpr std::uint64_t unlimited = 0x7FFF'FFFF'FFFF'F000;
  is_in("9:name=systemd:/\n5:cpu,cpuacct:/other\n4:memory:/slurm/job_7/task_0\n0::/\n");
  old_group("", unlimited, 90 * gib);
  old_group("slurm/job_7/task_0", unlimited, gib);
  EXPECT_EQ(available(), 100.0);
  old_group("slurm/job_7", 8 * gib, 7 * gib, 2 * gib);
  EXPECT_EQ(available(), 3.0);
  old_group("other", gib, gib);
  EXPECT_EQ(available(), 3.0) << "of another hierarchy";
  is_in("4:cpu,memory:/slurm/job_7\n");
  EXPECT_EQ(available(), 3.0);
  fs::remove(scratch / "proc/meminfo");
  is_in("4:memory:/slurm\n");
  EXPECT_EQ(available(), -1.0) << "what is rounded to pages is no limit";
}

TEST_F(AvailableMemory, IsBoundInAContainerThatDoesNotSeeItsOwnName) {
  group("", std::to_string(8 * gib), gib);
  is_in("0::/docker/0123abcd\n");
  EXPECT_EQ(available(), 7.0);
  is_in("0::/../../outside\n");
  group("../outside", std::to_string(gib), gib);
  EXPECT_EQ(available(), 7.0) << "what lies outside is not looked at";
}

TEST_F(BatchFiles, TheStateOfAnInputIsThatOfItsFiles) {
  write("session/rig.yaml", "rigcal: 1\n");
  write("session/patches/0.pcd", "12345");
  const InputState before = input_state({path("session")});
  EXPECT_EQ(before.bytes, 15U);
  EXPECT_EQ(before.digest, input_state({path("session")}).digest);
  fs::rename(scratch / "session", scratch / "moved");
  EXPECT_EQ(before.digest, input_state({path("moved")}).digest);
  EXPECT_NE(before.digest, input_state({path("session")}).digest) << "it is gone";
  const auto stamp = fs::last_write_time(scratch / "moved/patches/0.pcd");
  write("moved/patches/0.pcd", "54321");
  fs::last_write_time(scratch / "moved/patches/0.pcd", stamp + std::chrono::nanoseconds(1));
  EXPECT_NE(before.digest, input_state({path("moved")}).digest);
  fs::last_write_time(scratch / "moved/patches/0.pcd", stamp);
  EXPECT_EQ(before.digest, input_state({path("moved")}).digest);
  fs::rename(scratch / "moved/patches/0.pcd", scratch / "moved/patches/1.pcd");
  EXPECT_NE(before.digest, input_state({path("moved")}).digest);
}

TEST_F(BatchFiles, TheStateOfAnInputIsThatOfWhatItsLinksLeadToAsWell) {
  write("disk/avia/0.pcd", "12345");
  fs::create_directories(scratch / "session/patches");
  fs::create_directory_symlink(scratch / "disk/avia", scratch / "session/patches/avia");
  fs::create_directory_symlink(scratch / "session", scratch / "disk/avia/back");
  fs::create_symlink(scratch / "gone", scratch / "session/dangling");
  const InputState before = input_state({path("session")});
  EXPECT_EQ(before.bytes, 5U);
  EXPECT_FALSE(before.digest.empty());
  write("disk/avia/0.pcd", "123456");
  EXPECT_NE(before.digest, input_state({path("session")}).digest);
}

TEST_F(BatchFiles, TheStateOfAnInputTellsWhetherItMayBeRead) {
  write("session/lidar.pcapng", "points");
  fs::permissions(scratch, static_cast<fs::perms>(0755));  // Anybody may come as far as the file.
  const uid_t user = geteuid();
  const uid_t other = user == 0 ? 65534 : user;  // Nothing is closed to root.
  if (seteuid(other) != 0) GTEST_SKIP() << "cannot be anybody but root here";
  ASSERT_EQ(seteuid(user), 0);
  const auto state_with = [&](unsigned permissions) {
    fs::permissions(scratch / "session/lidar.pcapng", static_cast<fs::perms>(permissions));
    EXPECT_EQ(seteuid(other), 0);
    const InputState state = input_state({path("session")});
    EXPECT_EQ(seteuid(user), 0);
    return state.digest;
  };
  const std::string open = state_with(0644);
  EXPECT_NE(state_with(0), open);
  EXPECT_EQ(state_with(0444), open);
}

class Judge : public BatchFiles {
 protected:
  void SetUp() override {
    BatchFiles::SetUp();
    write("session", "points");
    work = {"session",      path("session"),     {path("session")}, {{"--require", "10mm,0.1deg"}},
            path("result"), path("session.json")};
    record.input = path("session");
    record.settings = work.settings;
    record.version = version();
    record.input_state = input_state(work.inputs).digest;
    record.wall_s = 1.5;
    record.cpu_s = 2.5;
    record.peak_memory_mb = 3.5;
    record.host = "here";
  }
  void note(int code, const std::string& error = {}) {
    record.code = code;
    record.error = error;
    record.of_input = !error.empty() && came_of_input(code, work.result);
    ASSERT_TRUE(write_record(record, work.record));
    if (error.empty()) put_result(code, "10mm,0.1deg");
  }
  void put_result(int code, const std::string& require) {
    write("result/extrinsics.yaml", "rigcal: 1\n");
    const std::string status = code == 0 ? "good" : "weak";
    write("result/report.json", std::string(R"({"versions": {"rigcal": ")") + version() + R"("}, "status": ")" +
                                    status + R"(", "settings": {"--require": ")" + require + "\"}}");
  }
  [[nodiscard]] Judgement judge(bool retry = false) const {
    const Expected<Judgement> judged = judge_session(work, input_state(work.inputs), retry, {});
    EXPECT_TRUE(judged) << judged.error().message();
    return judged ? *judged : Judgement{};
  }

  SessionWork work;
  AttemptRecord record;
};

TEST_F(Judge, CalibratesWhereThereIsNothingYet) {
  EXPECT_FALSE(judge().keep);
  EXPECT_EQ(judge().why, "there is no result yet");
}

TEST_F(Judge, KeepsWhatWouldComeOutTheSame) {
  note(1);
  const Judgement kept = judge();
  EXPECT_TRUE(kept.keep) << kept.why;
  EXPECT_EQ(kept.record->cpu_s, 2.5);
  EXPECT_EQ(kept.record->host, "here");
  fs::remove_all(scratch / "result");
  EXPECT_FALSE(judge().keep) << "the result was taken away";
}

TEST_F(Judge, DoesNotVouchForAResultThatWasPutInThePlaceOfItsOwn) {
  note(1);
  put_result(1, "5mm,0.05deg");
  EXPECT_FALSE(judge().keep);
  EXPECT_EQ(judge().why, "the result was made with another --require");
  put_result(0, "10mm,0.1deg");
  EXPECT_FALSE(judge().keep) << "the record says that it was weak";
  put_result(1, "10mm,0.1deg");
  EXPECT_TRUE(judge().keep);
}

TEST_F(Judge, CalibratesAgainForOtherInputsOptionsAndVersions) {
  note(0);
  work.settings[0].second = "5mm,0.05deg";
  EXPECT_EQ(judge().why, "the result was made with another --require");
  EXPECT_FALSE(judge().keep);
  work.settings = record.settings;
  write("session", "other points");
  EXPECT_FALSE(judge().keep) << "the result has no report to compare with";
  write("session", "points");
  record.version = "0.0.1";
  note(0);
  EXPECT_EQ(judge().why, "the result is of rigcal 0.0.1");
}

TEST_F(Judge, KeepsAFailureThatCameOfTheInputAndTriesOthersAgain) {
  note(3, "session: is empty");
  EXPECT_TRUE(judge().keep);
  EXPECT_EQ(judge().record->error, "session: is empty");
  EXPECT_FALSE(judge(true).keep) << "--retry";
  write("session", "mended");
  EXPECT_FALSE(judge().keep);
  write("session", "points");
  for (const int code : {4, -1}) {
    note(code, "disk full, or a crash");
    EXPECT_FALSE(judge().keep) << code;
  }
}

TEST_F(Judge, TriesAgainWhatFailedBecauseOfWhatStoodInItsPlace) {
  write("result/thesis.tex", "years of work");
  EXPECT_FALSE(came_of_input(3, work.result));
  EXPECT_TRUE(came_of_input(2, work.result));
  EXPECT_FALSE(came_of_input(4, path("elsewhere")));
  EXPECT_FALSE(came_of_input(-1, path("elsewhere")));
  EXPECT_TRUE(came_of_input(3, path("elsewhere")));
  note(3, "the folder holds \"thesis.tex\", which is no part of a result");
  EXPECT_FALSE(judge().keep);
  fs::remove_all(scratch / "result");
  EXPECT_FALSE(judge().keep) << "its mend was followed";
  EXPECT_EQ(judge().why, "failed before");
}

// SIGTERM ends `rigcal calibrate` with code 1 and without a result; the one before is still there.
TEST_F(Judge, TriesAgainWhatSomebodyElseEnded) {
  note(0);
  note(1, "ended with exit code 1 and no word");
  EXPECT_FALSE(judge().keep);
  EXPECT_EQ(judge().why, "failed before");
}

TEST_F(Judge, ReplacesNoResultOfAnotherRecording) {
  note(0);
  write("elsewhere/session", "points of another rig");
  work.input = path("elsewhere/session");
  work.inputs = {work.input};
  const auto refused = judge_session(work, input_state(work.inputs), false, {});
  ASSERT_FALSE(refused);
  EXPECT_THAT(refused.error().message(), HasSubstr(path("elsewhere/session") + ": its result would replace that of " +
                                                   path("session") + ", which is called \"session\" there, too"));
  // The same files in another place, or a path that leads there, are the same recording.
  fs::remove_all(scratch / "elsewhere");
  fs::create_directories(scratch / "elsewhere");
  fs::rename(scratch / "session", scratch / "elsewhere/session");
  EXPECT_TRUE(judge().keep);
  fs::create_symlink(scratch / "elsewhere/session", scratch / "session");
  write("elsewhere/session", "points, mended");
  EXPECT_FALSE(judge().keep);
}

// Records are JSON, in which bytes that are no UTF-8 cannot stand.
TEST_F(Judge, KnowsNamesAgainThatAreNoUtf8) {
  write("b\xFCro/session", "points");
  work.input = path("b\xFCro/session");
  work.inputs = {work.input};
  work.settings.emplace_back("--rig", path("b\xFCro/rig.yaml"));
  record.input = work.input;
  record.settings = work.settings;
  record.input_state = input_state(work.inputs).digest;
  note(3, "session: is empty");
  EXPECT_TRUE(judge().keep) << judge().why;
  work.settings[0].second = "5mm,0.05deg";
  EXPECT_EQ(judge().why, "failed before, and something has changed since") << "not another recording";
  work.settings[1].second = path("other.yaml");
  EXPECT_FALSE(judge().keep);
}

TEST_F(Judge, ReplacesNoResultOfAnotherRecordingThatHasNoRecord) {
  write("result/extrinsics.yaml", "rigcal: 1\n");
  write("elsewhere/session", "points of another rig");
  const std::string report = R"({"rigcal": 1, "settings": {"INPUT": ")";
  write("result/report.json", report + path("elsewhere/session") + "\"}}");
  EXPECT_FALSE(judge_session(work, input_state(work.inputs), false, {}));
  write("result/report.json", report + path("session/") + "\"}}");
  EXPECT_FALSE(judge().keep);
  write("result/report.json", report + "no path from here\"}}");
  EXPECT_FALSE(judge().keep);
}

TEST_F(Judge, KeepsNothingWhoseInputCannotBeLookedAt) {
  note(0);
  record.input_state.clear();
  note(0);
  EXPECT_FALSE(judge_session(work, InputState{}, false, {})->keep);
}

TEST_F(Judge, DoesNotTrustARecordThatIsNone) {
  note(0);
  write("session.json", "{\"rigcal\": 1, \"settings\": 7}");
  EXPECT_FALSE(read_record(work.record).has_value());
  EXPECT_FALSE(judge().keep);
  write("result/report.json", "{\"rigcal\": 1, \"versions\": [], \"settings\": 7}");
  EXPECT_FALSE(judge().keep);
}

TEST_F(Judge, AResultSaysWithWhichCodeItsCalibrationEnded) {
  EXPECT_EQ(code_of_result(work.result), std::nullopt) << "nothing was written yet";
  write("result/report.json", R"({"status": "good"})");
  EXPECT_EQ(code_of_result(work.result), 0);
  write("result/report.json", R"({"status": "weak"})");
  EXPECT_EQ(code_of_result(work.result), 1);
  write("result/report.json", R"({"status": 7})");
  EXPECT_EQ(code_of_result(work.result), std::nullopt);
  write("result/report.json", R"({"status": "good")");
  EXPECT_EQ(code_of_result(work.result), std::nullopt) << "cut off";
}

TEST(Forecast, WaitsUntilAShareOfAllBytesIsDone) {
  EXPECT_EQ(forecast_text(10.0, 0.0, 1e9), "") << "the first failed";
  EXPECT_EQ(forecast_text(10.0, 1.0, 1e9), "");
  EXPECT_EQ(forecast_text(10.0, 4e7, 1e9), "");
  EXPECT_EQ(forecast_text(10.0, 1e8, 4e8), ", about 40 s left");
  EXPECT_EQ(forecast_text(60.0, 1e8, 4e8), ", about 4 min left");
}

TEST(BatchTable, QuotesWhatACsvMustQuote) {
  BatchOutcome outcome;
  SessionRow& row = outcome.rows.emplace_back();
  row.session = {"a,b", "in\"put"};
  row.status = "failed";
  row.error = "line 3: bad, \"very\"";
  EXPECT_THAT(batch_csv(outcome),
              HasSubstr("\r\n\"a,b\",\"in\"\"put\",,failed,,,,,,,,,,\"line 3: bad, \"\"very\"\"\","));
  const auto json = parse_json(batch_json(outcome, "out"));
  EXPECT_TRUE(fits_schema("batch.json", json));
  EXPECT_EQ(json["failed"], 1);
}

TEST(BatchTable, HasQuaternionsOfTheSignThatResultsHave) {
  BatchOutcome outcome;
  SessionRow& row = outcome.rows.emplace_back();
  row.status = "good";
  SensorRow& sensor = row.sensors.emplace_back();
  sensor.status = "good";
  sensor.placed = true;
  sensor.T_base_sensor.R = exp_so3({0.2, 0.0, 3.2});  // past half a turn
  const auto json = parse_json(batch_json(outcome, "out"));
  const auto found = json["sessions"][0]["sensors"][0]["rotation_xyzw"];
  const Eigen::Vector4d wanted = xyzw_from_rotation(sensor.T_base_sensor.R);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(found[i].get<double>(), wanted[i]);
  EXPECT_GT(wanted[3], 0.0);
}

}  // namespace
}  // namespace rigcal::batch
