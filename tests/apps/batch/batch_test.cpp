// `rigcal batch` as a user runs it, on small simulated sessions, one of them damaged.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

constexpr int sessions = 3;
constexpr auto patience = std::chrono::seconds(120);

bool wait_until(const std::function<bool()>& happened) {
  const auto end = std::chrono::steady_clock::now() + patience;
  while (!happened()) {
    if (std::chrono::steady_clock::now() > end) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return true;
}

std::vector<pid_t> children_of(pid_t process) {
  const std::string id = std::to_string(process);
  std::istringstream in(text_of("/proc/" + id + "/task/" + id + "/children"));
  std::vector<pid_t> found;
  for (pid_t child = 0; in >> child;) found.push_back(child);
  return found;
}

class Batch : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("batch");
    std::ofstream(scratch / "rig.yaml") << small_rig();
    fs::create_directories(scratch / "fleet/broken");
    for (int k = 1; k <= sessions; ++k) {
      const std::string name = "car" + std::to_string(k);
      ASSERT_EQ(rigcal("simulate courtyard --rig rig.yaml --patches --stops 12 --points 8000 --seed " +
                       std::to_string(k) + " --out fleet/" + name + " --quiet")
                    .code,
                0);
    }
    std::ofstream(scratch / "fleet/broken/session.json") << "{";
    std::ofstream(scratch / "fleet/broken/rig.yaml") << "rigcal: 1\nbase: nobody\n";
  }

  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  // Runs beside the test; what it says goes to files that nobody reads.
  static pid_t start(const std::vector<std::string>& arguments) {
    std::vector<std::string> words{"rigcal"};
    words.insert(words.end(), arguments.begin(), arguments.end());
    std::vector<char*> given;
    given.reserve(words.size() + 1);
    for (std::string& word : words) given.push_back(word.data());
    given.push_back(nullptr);
    const std::string folder = scratch.string();
    const pid_t child = fork();
    if (child == 0) {
      if (chdir(folder.c_str()) != 0 || std::freopen("/dev/null", "w", stderr) == nullptr ||
          std::freopen("/dev/null", "w", stdout) == nullptr)
        _exit(98);
      execv(RIGCAL_PROGRAM, given.data());
      _exit(99);
    }
    return child;
  }
  static int exit_code(pid_t process) {
    int status = 0;
    EXPECT_EQ(waitpid(process, &status, 0), process);
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  static nlohmann::json table(const std::string& folder) {
    const auto json = try_json(text_of(scratch / folder / "batch.json"));
    EXPECT_TRUE(fits_schema("batch.json", json));
    return json;
  }
  // Hidden folders that a result was being written to.
  static std::vector<std::string> left_parts(const std::string& folder) {
    std::vector<std::string> found;
    for (const auto& entry : fs::directory_iterator(scratch / folder)) {
      const std::string name = entry.path().filename();
      if (name.find(".part") != std::string::npos) found.push_back(name);
    }
    return found;
  }
  static bool has_result(const std::string& folder) { return fs::exists(scratch / folder / "extrinsics.yaml"); }
  static void expect_like_single(const std::string& batch, const std::string& name) {
    if (!has_result("single_" + name)) rigcal("calibrate fleet/" + name + " --out single_" + name);
    for (const std::string file : {"extrinsics.yaml", "trajectory.tum", "map.ply"}) {
      const std::string made = text_of(scratch / batch / name / file);
      EXPECT_FALSE(made.empty()) << batch << "/" << name << "/" << file;
      EXPECT_TRUE(made == text_of(scratch / ("single_" + name) / file)) << batch << "/" << name << "/" << file;
    }
  }

  inline static fs::path scratch;
};

TEST_F(Batch, GivesEachSessionTheResultOfCalibrateAndARow) {
  const ProgramRun run = rigcal("batch fleet/car1 fleet/broken fleet/car2 --out all --json");
  EXPECT_EQ(run.code, 1) << run.err;
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("batch.json", json));
  EXPECT_EQ(table("all")["sessions"], json["sessions"]);
  EXPECT_EQ(json["failed"], 1);
  EXPECT_EQ(json["waiting"], 0);
  const auto& broken = json["sessions"][1];
  EXPECT_EQ(broken["name"], "broken");
  EXPECT_EQ(broken["status"], "failed");
  EXPECT_EQ(broken["exit_code"], 3);
  EXPECT_THAT(broken["error"].get<std::string>(), HasSubstr("fleet/broken"));
  EXPECT_TRUE(broken["sensors"].empty());
  for (const std::size_t k : {0U, 2U}) {
    const auto& row = json["sessions"][k];
    EXPECT_EQ(row["why"], "there is no result yet");
    EXPECT_GT(row["peak_memory_mb"], 10.0);
    ASSERT_EQ(row["sensors"].size(), 2U);
    EXPECT_EQ(row["sensors"][1]["name"], "mid40");
    EXPECT_GT(row["sensors"][1]["sigma_mm"], 0.1);
    expect_like_single("all", row["name"]);
  }
  const std::string csv = text_of(scratch / "all/batch.csv");
  EXPECT_THAT(csv, HasSubstr("\r\ncar1,fleet/car1,mid40,good,"));
  EXPECT_THAT(csv, HasSubstr("\r\nbroken,fleet/broken,,failed,"));
  EXPECT_THAT(run.err, HasSubstr("car1: good"));
}

TEST_F(Batch, KeepsWhatIsDoneUntilSomethingChanges) {
  ASSERT_EQ(rigcal("batch fleet/car1 fleet/broken --out kept --quiet").code, 1);
  const auto stamp = fs::last_write_time(scratch / "kept/car1/extrinsics.yaml");
  std::ofstream(scratch / "list.txt") << "fleet/car1\nfleet/broken\n";
  const auto why = [&](const std::string& more) {
    const ProgramRun run = rigcal("batch --list list.txt --out kept --json " + more);
    EXPECT_EQ(run.code, 1) << run.err;
    const auto json = parse_json(run.out);
    return std::vector<std::string>{json["sessions"][0]["why"], json["sessions"][1]["why"]};
  };
  EXPECT_THAT(why(""), ElementsAre("nothing has changed since", "failed before, and nothing has changed since"));
  EXPECT_THAT(why("--retry"), ElementsAre("nothing has changed since", "failed before"));
  fs::last_write_time(scratch / "fleet/car1/rig.yaml", fs::file_time_type::clock::now());
  EXPECT_THAT(why("").front(), "the same bytes and options made it");
  EXPECT_THAT(why("").front(), "nothing has changed since") << "it is known by then";
  fs::remove_all(scratch / "kept/.batch/car1.json");
  EXPECT_THAT(why("").front(), "the same bytes and options made it");
  EXPECT_EQ(fs::last_write_time(scratch / "kept/car1/extrinsics.yaml"), stamp);

  EXPECT_THAT(why("--require 20mm,0.2deg").front(), "the result was made with another --require");
  EXPECT_NE(fs::last_write_time(scratch / "kept/car1/extrinsics.yaml"), stamp);
  fs::copy(scratch / "fleet/car1", scratch / "changed", fs::copy_options::recursive);
  ASSERT_EQ(rigcal("batch changed --out kept --quiet").code, 0);
  std::ofstream(scratch / "changed/rig.yaml", std::ios::app) << "# another byte\n";
  const auto again = parse_json(rigcal("batch changed --out kept --json").out);
  EXPECT_EQ(again["sessions"][0]["why"], "the input has changed");
}

TEST_F(Batch, StopsAtCtrlCAndGoesOnWhereItWas) {
  const std::vector<std::string> all{"batch", "fleet/car1", "fleet/car2", "fleet/car3", "--out", "stopped", "--jobs=1"};
  const pid_t batch = start(all);
  ASSERT_TRUE(wait_until([] { return has_result("stopped/car1"); }));
  ASSERT_TRUE(wait_until([&] { return !children_of(batch).empty(); }));
  const std::vector<pid_t> children = children_of(batch);
  kill(batch, SIGINT);
  EXPECT_EQ(exit_code(batch), 1);
  for (const pid_t child : children) EXPECT_NE(kill(child, 0), 0) << "it ends after its children";
  EXPECT_THAT(left_parts("stopped"), IsEmpty());
  const auto before = table("stopped");
  EXPECT_TRUE(before["stopped"]);
  EXPECT_GE(before["waiting"], 1);
  EXPECT_EQ(before["failed"], 0) << json_text(before);

  const auto stamp = fs::last_write_time(scratch / "stopped/car1/extrinsics.yaml");
  EXPECT_EQ(exit_code(start(all)), 0);
  const auto after = table("stopped");
  EXPECT_EQ(after["good"], sessions);
  EXPECT_EQ(after["kept"], sessions - before["waiting"].get<int>());
  EXPECT_EQ(fs::last_write_time(scratch / "stopped/car1/extrinsics.yaml"), stamp);
  expect_like_single("stopped", "car3");
}

TEST_F(Batch, ACalibrationThatIsKilledIsARowAndIsTriedAgain) {
  const std::vector<std::string> all{"batch", "fleet/car1", "fleet/car2", "--out", "killed", "--jobs=1"};
  const pid_t batch = start(all);
  ASSERT_TRUE(wait_until([&] { return !children_of(batch).empty(); }));
  kill(children_of(batch).front(), SIGKILL);
  EXPECT_EQ(exit_code(batch), 1);
  const auto before = table("killed");
  EXPECT_THAT(before["sessions"][0]["error"].get<std::string>(), HasSubstr("ended by a signal (Killed)"));
  EXPECT_EQ(before["sessions"][0]["exit_code"], -1);
  EXPECT_EQ(before["sessions"][1]["status"], "good");
  EXPECT_FALSE(has_result("killed/car1"));
  EXPECT_THAT(left_parts("killed"), IsEmpty());
  EXPECT_EQ(exit_code(start(all)), 0);
  EXPECT_EQ(table("killed")["sessions"][0]["why"], "failed before");
  expect_like_single("killed", "car1");
}

TEST_F(Batch, SharesAFolderWithOthersAndTakesUpWhatTheyLeave) {
  const std::vector<std::string> all{"batch", "fleet/car1", "fleet/car2", "fleet/car3", "--out", "shared", "--jobs=1"};
  const pid_t one = start(all);
  const pid_t other = start(all);
  const pid_t third = start(all);
  ASSERT_TRUE(wait_until([&] { return !children_of(third).empty() || has_result("shared/car2"); }));
  const std::vector<pid_t> orphans = children_of(third);
  kill(third, SIGKILL);
  for (const pid_t orphan : orphans) kill(orphan, SIGKILL);
  EXPECT_EQ(exit_code(third), -1);
  EXPECT_EQ(exit_code(one), 0);
  EXPECT_EQ(exit_code(other), 0);
  const auto json = table("shared");
  EXPECT_EQ(json["good"], sessions);
  EXPECT_THAT(left_parts("shared"), IsEmpty());
  for (int k = 1; k <= sessions; ++k) expect_like_single("shared", "car" + std::to_string(k));
}

TEST_F(Batch, TriesAgainWhereTheMendOfAFailureWasFollowed) {
  fs::create_directories(scratch / "foreign/.batch");
  fs::create_directories(scratch / "foreign/car1");
  std::ofstream(scratch / "foreign/car1/notes.txt") << "by hand";
  const auto run = [] { return parse_json(rigcal("batch fleet/car1 --out foreign --json").out)["sessions"][0]; };
  const auto refused = run();
  EXPECT_EQ(refused["exit_code"], 3);
  EXPECT_THAT(refused["error"].get<std::string>(), HasSubstr("notes.txt"));
  fs::rename(scratch / "foreign/car1/notes.txt", scratch / "notes.txt");
  const auto again = run();
  EXPECT_EQ(again["status"], "good");
  EXPECT_EQ(again["why"], "failed before");
}

TEST_F(Batch, ADiskThatFailsIsNoFaultOfTheInput) {
  fs::create_directories(scratch / "sick");
  fs::copy_file(scratch / "rig.yaml", scratch / "sick/rig.yaml");
  fs::create_symlink("/proc/self/mem", scratch / "sick/lidar.pcapng");  // Reading it gives EIO.
  for (int tries = 0; tries < 2; ++tries) {
    const auto row = parse_json(rigcal("batch sick --out from_sick --json").out)["sessions"][0];
    EXPECT_EQ(row["exit_code"], 4) << json_text(row);
    EXPECT_THAT(row["error"].get<std::string>(), HasSubstr("cannot be read to its end (Input/output error)"));
    EXPECT_EQ(row["kept"], false);
  }
}

TEST_F(Batch, RefusesWhatIsNoFolderOfABatchAndWhatIsNoList) {
  fs::create_directories(scratch / "thesis");
  std::ofstream(scratch / "thesis/chapter.tex") << "years of work";
  const ProgramRun foreign = rigcal("batch fleet/car1 --out thesis");
  EXPECT_EQ(foreign.code, 3);
  EXPECT_THAT(foreign.err, HasSubstr("thesis: is not empty and no folder of a batch; choose another --out"));
  EXPECT_EQ(rigcal("batch --out nothing").code, 2);
  EXPECT_EQ(rigcal("batch fleet/car1 fleet/car1 --out nothing").code, 2);
  EXPECT_FALSE(fs::exists(scratch / "nothing"));
  EXPECT_EQ(rigcal("batch --list none.txt --out nothing").code, 3);
  const ProgramRun rigless = rigcal("batch fleet/car1 fleet/car2 --out nothing --rig none.yaml");
  EXPECT_EQ(rigless.code, 3);
  EXPECT_THAT(rigless.err, HasSubstr("error: none.yaml: there is no such file"));
  EXPECT_EQ(rigcal("batch fleet/car1 --out nothing --initial none.yaml").code, 3);
  EXPECT_FALSE(fs::exists(scratch / "nothing"));
  EXPECT_EQ(rigcal("batch fleet/car1 --out nothing --memory much").code, 2);
  EXPECT_EQ(rigcal("batch fleet/car1 --out nothing --method planes --stages joint").code, 2);
  EXPECT_THAT(rigcal("batch fleet/car1 --out nothing --require 5 --jobs 2").err, HasSubstr("--require"));
}

}  // namespace
}  // namespace rigcal
