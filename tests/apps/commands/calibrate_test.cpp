// `rigcal calibrate` as a user runs it, on one simulated run of an AVIA and a MID-40.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "core/io/extrinsics_file.h"
#include "core/io/pcap_reader.h"
#include "tests/apps/commands/lvx_recording.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::AllOf;
using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

const std::string rig_yaml = small_rig();

class Calibrate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("calibrate");
    std::ofstream(scratch / "rig.yaml") << rig_yaml;
    simulate("session", {});
    fs::create_directories(scratch / "first/overlays");
    std::ofstream(scratch / "first/extrinsics.yaml") << "rigcal: 1\nbase: something else\n";
    std::ofstream(scratch / "first/report.html") << "of last year";
    std::ofstream(scratch / "first/overlays/gone_3.jpg") << "of last year";
    first = rigcal("calibrate session --out first --threads 2 --json");
  }
  static void simulate(const std::string& name, const sim::FaultOptions& faults) {
    sim::RunOptions run = hurried_run(10, 0.9);
    run.faults = faults;
    simulate_courtyard(rig_yaml, run, scratch / name);
  }

  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  static std::string file(const std::string& name) { return text_of(scratch / name); }
  static ExtrinsicsFile extrinsics(const std::string& name) {
    const auto loaded = load_extrinsics((scratch / name).string());
    EXPECT_TRUE(loaded) << loaded.error().message();
    return loaded ? *loaded : ExtrinsicsFile{};
  }
  static void expect_near(const std::string& result, const std::string& other, double mm, double deg) {
    const ExtrinsicsFile a = extrinsics(result);
    const ExtrinsicsFile b = extrinsics(other);
    ASSERT_THAT(a.T_base_sensor, Contains(testing::Key("mid40"))) << file(result);
    const SE3& T = a.T_base_sensor.at("mid40");
    const SE3& other_T = b.T_base_sensor.at("mid40");
    EXPECT_LT(1e3 * (T.t - other_T.t).norm(), mm) << result;
    EXPECT_LT(to_deg(rotation_distance(T.R, other_T.R)), deg) << result;
  }

  inline static fs::path scratch;
  inline static ProgramRun first;
};

TEST_F(Calibrate, TellsAfterEachStopWhatIsKnownAndEndsAlike) {
  const ProgramRun run = rigcal("calibrate session --out stepwise --incremental --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(file("stepwise/extrinsics.yaml") == file("first/extrinsics.yaml"));
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("calibrate.json", json));
  const auto estimates = json["estimates"];
  ASSERT_EQ(estimates.size(), 10U);
  EXPECT_FALSE(estimates.front()["reached"]);
  EXPECT_TRUE(estimates.back()["reached"]);
  EXPECT_EQ(estimates.back()["advice"]["turns"].size(), 23U);
}

TEST_F(Calibrate, FindsTheExtrinsicsOfASession) {
  ASSERT_EQ(first.code, 0) << first.err << first.out;
  // Twice the sigma of the worst axis (2.4 mm, 0.007 deg), the turn with room for the walls' own; seen: 0.4 mm, 0.001.
  expect_near("first/extrinsics.yaml", "session/ground_truth.yaml", 5.0, 0.05);
  EXPECT_THAT(extrinsics("first/extrinsics.yaml").status, Contains(testing::Pair("mid40", "good")));
}

TEST_F(Calibrate, DoesNotMindInWhichOrderTheRigFileHasItsSensors) {
  std::string turned = rig_yaml;
  const std::size_t begin = turned.find("  mid40: {type");
  const std::string mid40 = turned.substr(begin, turned.find('\n', begin) + 1 - begin);
  turned.erase(begin, mid40.size());
  turned.insert(turned.find("  avia: {type"), mid40);
  std::ofstream(scratch / "turned.yaml") << turned;
  ASSERT_EQ(rigcal("calibrate session --rig rig.yaml --out straight").code, 0);
  ASSERT_EQ(rigcal("calibrate session --rig turned.yaml --out turned").code, 0);
  const ExtrinsicsFile a = extrinsics("straight/extrinsics.yaml");
  const ExtrinsicsFile b = extrinsics("turned/extrinsics.yaml");
  EXPECT_EQ(b.names, (std::vector<std::string>{"mid40", "avia"})) << "results keep it";
  EXPECT_TRUE(a.T_base_sensor.at("mid40").matrix() == b.T_base_sensor.at("mid40").matrix());
  EXPECT_TRUE(a.covariance.at("mid40") == b.covariance.at("mid40"));
}

TEST_F(Calibrate, FindsThemWithoutAGuess) {
  // Of turns of 18 degrees: in those of 36 the MID-40 does not see the same from two neighbouring stops.
  ASSERT_EQ(rigcal("simulate courtyard --rig rig.yaml --out small_turns --patches --stops 20 --points 8000").code, 0);
  const ProgramRun run = rigcal("calibrate small_turns --out unguessed --initial none");
  EXPECT_EQ(run.code, 0) << run.err << run.out;
  expect_near("unguessed/extrinsics.yaml", "small_turns/ground_truth.yaml", 5.0, 0.05);
  const auto report = parse_json(file("unguessed/report.json"));
  EXPECT_TRUE(fits_schema("report.json", report));
}

TEST_F(Calibrate, FindsThemWhereOnePacketInTwentyIsLostAndOthersComeTwiceOrLate) {
  sim::FaultOptions faults;
  faults.loss = 0.05;
  faults.duplicate = faults.reorder = faults.delay = 0.01;
  simulate("lossy", faults);
  const ProgramRun run = rigcal("calibrate lossy --out from_lossy");
  EXPECT_EQ(run.code, 0) << run.err << run.out;
  expect_near("from_lossy/extrinsics.yaml", "lossy/ground_truth.yaml", 5.0, 0.05);
  const auto report = parse_json(file("from_lossy/report.json"));
  EXPECT_TRUE(fits_schema("report.json", report));
  for (const char* sensor : {"avia", "mid40"}) {
    const auto& packets = report["packets"][sensor];
    EXPECT_NEAR(packets["point_lost"].get<double>() / packets["point_expected"].get<double>(), 0.05, 0.01);
    EXPECT_GT(packets["point_duplicated"], 50);
    EXPECT_GT(packets["point_out_of_order"], 100);
  }
  EXPECT_GT(report["packets"]["avia"]["imu_lost"], 50);
  fs::remove_all(scratch / "lossy");
}

TEST_F(Calibrate, PrintsOneJsonObject) {
  const auto json = parse_json(first.out);
  EXPECT_TRUE(fits_schema("calibrate.json", json));
  EXPECT_EQ(json["stops"]["solved"], 10);
  EXPECT_EQ(json["out"], "first");
  const auto report = parse_json(file("first/report.json"));
  EXPECT_TRUE(fits_schema("report.json", report));
}

TEST_F(Calibrate, TellsByHowMuchDarkSurfacesSeemFarther) {
  ASSERT_EQ(
      rigcal("simulate courtyard --rig rig.yaml --out dark --patches --stops 20 --points 20000 --dark-bias 20").code,
      0);
  const ProgramRun run = rigcal("calibrate dark --out of_dark --json");
  ASSERT_EQ(run.code, 0) << run.err << run.out;
  expect_near("of_dark/extrinsics.yaml", "dark/ground_truth.yaml", 5.0, 0.05);
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("calibrate.json", json));
  EXPECT_TRUE(fits_schema("report.json", parse_json(file("of_dark/report.json"))));
  for (const auto& sensor : json["sensors"]) {
    const auto& dark = sensor["dark_offset"];
    EXPECT_NEAR(dark["mm"].get<double>(), 20.0, 4.0 * dark["sigma_mm"].get<double>()) << sensor["name"];
    EXPECT_LT(dark["sigma_mm"], 3.0);
  }
}

TEST_F(Calibrate, GivesTheSameBytesAgainWithOneThreadAndFromTheDumpAlone) {
  EXPECT_EQ(rigcal("calibrate session --out one --threads 1").code, 0);
  EXPECT_EQ(rigcal("calibrate session/lidar.pcapng --rig session/rig.yaml --out dump --threads 2").code, 0);
  for (const std::string name : {"extrinsics.yaml", "trajectory.tum", "map.ply"}) {
    EXPECT_FALSE(file("first/" + name).empty()) << name;
    // Not EXPECT_EQ: its diff of two large texts takes memory with the square of their lines.
    EXPECT_TRUE(file("first/" + name) == file("one/" + name)) << name;
    EXPECT_TRUE(file("first/" + name) == file("dump/" + name)) << name;
  }
}

TEST_F(Calibrate, GivesTheSameFromItsExportedPatches) {
  ASSERT_EQ(rigcal("export session --format patches --out patches").code, 0);
  const ProgramRun run = rigcal("calibrate patches --out from_patches");  // by its own rig file
  EXPECT_EQ(run.code, 0) << run.err;
  // Coordinates are floats in both; nothing but text of poses is rounded on the way.
  expect_near("from_patches/extrinsics.yaml", "first/extrinsics.yaml", 0.1, 0.001);
  fs::remove(scratch / "patches/rig.yaml");
  const ProgramRun without = rigcal("calibrate patches --out without_rig");
  EXPECT_EQ(without.code, 3);
  EXPECT_THAT(without.err, HasSubstr("patches: a patch folder needs a rig file; add --rig"));
  fs::remove_all(scratch / "patches/avia");
  const ProgramRun blind = rigcal("calibrate patches --rig rig.yaml --out from_blind_base");
  EXPECT_EQ(blind.code, 1);
  EXPECT_THAT(blind.out, testing::ContainsRegex("  avia +failed\n    - it has no points"));
  EXPECT_THAT(blind.out, HasSubstr("avia, the base, has no points in any stop"));
  EXPECT_FALSE(fs::exists(scratch / "without_rig"));
}

// The dwells of this run are short for points: some stops may be too short, but those that are found must be right.
TEST_F(Calibrate, FindsTheStopsFromThePointsWhereThereIsNoGyro) {
  std::string text = rig_yaml;
  text.insert(text.find("ip: 192.168.1.179"), "imu: false, ");
  std::ofstream(scratch / "no_gyro.yaml") << text;
  const ProgramRun run = rigcal("calibrate session --rig no_gyro.yaml --out no_gyro");
  EXPECT_LE(run.code, 1) << run.err << run.out;
  expect_near("no_gyro/extrinsics.yaml", "session/ground_truth.yaml", 10.0, 0.1);

  const ProgramRun seen = rigcal("inspect session --rig no_gyro.yaml --json");
  const auto json = parse_json(seen.out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["stops_from"], "points");
  EXPECT_GE(json["stops"].size(), 8U);
  EXPECT_LE(json["stops"].size(), 10U);
  EXPECT_LT(json["view"]["resolution_deg"], 0.1);
  EXPECT_FALSE(json.contains("gyro"));
  EXPECT_THAT(rigcal("inspect session --rig no_gyro.yaml").out, HasSubstr("stops found from the points; they show"));
  EXPECT_THAT(rigcal("inspect session").out, HasSubstr("stops found from the gyro, the points watch for creep"));
}

TEST_F(Calibrate, GivesTheSameFromAnLvxRecording) {
  const LvxDevice avia = small_rig_avia();
  LvxDevice mid40 = small_rig_mid40();
  mid40.roll_pitch_yaw_deg = {1.0F, 2.0F, 3.0F};
  save_as_lvx((scratch / "session/lidar.pcapng").string(), avia, mid40, (scratch / "run.lvx").string());
  const ProgramRun run = rigcal("calibrate run.lvx --rig rig.yaml --out from_lvx");
  EXPECT_EQ(run.code, 0) << run.err;
  // The same points; the edges of the stops differ by what the paths of the packets are known to.
  expect_near("from_lvx/extrinsics.yaml", "first/extrinsics.yaml", 1.0, 0.01);

  ASSERT_EQ(rigcal("import run.lvx --rig rig.yaml --out of_lvx --quiet").code, 0);
  ASSERT_LE(rigcal("calibrate of_lvx --out from_of_lvx --quiet").code, 1);
  EXPECT_TRUE(file("from_of_lvx/extrinsics.yaml") == file("from_lvx/extrinsics.yaml")) << "to the bit";

  const ProgramRun look = rigcal("inspect run.lvx --rig rig.yaml --json");
  EXPECT_EQ(look.code, 0) << look.err;
  const auto json = parse_json(look.out);
  EXPECT_TRUE(fits_schema("inspect.json", json));
  EXPECT_EQ(json["stops"].size(), 10U);
  EXPECT_EQ(json["devices"][0]["sensor"], "avia");
  EXPECT_EQ(json["devices"][1]["sensor"], "mid40");
  EXPECT_EQ(json["devices"][1]["point_packets"]["lost"], 0);
  ASSERT_EQ(json["file_extrinsics"].size(), 1U);
  EXPECT_EQ(json["file_extrinsics"][0]["broadcast_code"], "0TFDG3B00600551");
  EXPECT_THAT(rigcal("inspect run.lvx").out, HasSubstr("roll 1.000, pitch 2.000, yaw 3.000 deg"));
  fs::resize_file(scratch / "run.lvx", fs::file_size(scratch / "run.lvx") - 1);
  const ProgramRun cut = rigcal("export run.lvx --rig rig.yaml --format patches --out lvx_patches");
  EXPECT_EQ(cut.code, 1);
  EXPECT_THAT(cut.err, HasSubstr("run.lvx: after frame "));
  fs::remove(scratch / "run.lvx");
}

TEST_F(Calibrate, TakesWhatIsWholeOfADumpThatWasCut) {
  const fs::path cut = scratch / "cut.pcapng";
  fs::copy_file(scratch / "session/lidar.pcapng", cut);
  fs::resize_file(cut, fs::file_size(cut) * 7 / 10);
  const ProgramRun run = rigcal("calibrate cut.pcapng --rig rig.yaml --out from_cut");
  EXPECT_THAT(run.code, testing::AnyOf(0, 1)) << run.err;
  EXPECT_THAT(run.err, HasSubstr("rigcal: warning: cut.pcapng: "));
  EXPECT_THAT(file("from_cut/report.json"), HasSubstr("cut.pcapng: "));
  // Seven of ten stops and less than a full turn: twice the bound of the whole (seen: 1.1 mm, 0.003 deg).
  expect_near("from_cut/extrinsics.yaml", "session/ground_truth.yaml", 10.0, 0.1);
}

TEST_F(Calibrate, DoesNotCallSolvedWhatAnEarlyEndLeftUnsolved) {
  EXPECT_EQ(rigcal("calibrate session --out poses --stages poses").code, 1);
  const ExtrinsicsFile poses = extrinsics("poses/extrinsics.yaml");
  EXPECT_EQ(poses.status.at("mid40"), "failed");
  EXPECT_EQ(poses.T_base_sensor.count("mid40"), 0U);
  EXPECT_THAT(file("poses/extrinsics.yaml"), HasSubstr("the run ended before the extrinsics"));

  EXPECT_EQ(rigcal("calibrate session --out rough --stages extrinsics").code, 1);
  EXPECT_EQ(extrinsics("rough/extrinsics.yaml").status.at("mid40"), "weak");
  EXPECT_THAT(file("rough/extrinsics.yaml"),
              HasSubstr("the run ended before poses and extrinsics were adjusted together"));
  // Poses of the base alone, one pass with loose gates: a centimetre or two (seen: 1.0 mm, 0.001 deg).
  expect_near("rough/extrinsics.yaml", "session/ground_truth.yaml", 20.0, 0.2);
}

TEST_F(Calibrate, ReplacesAnOlderResultAndNothingElse) {
  EXPECT_EQ(extrinsics("first/extrinsics.yaml").base, "avia");
  EXPECT_THAT(file("first/report.html"), AllOf(Not(IsEmpty()), Not(HasSubstr("of last year"))));
  EXPECT_FALSE(fs::exists(scratch / "first/overlays/gone_3.jpg"));

  fs::create_directories(scratch / "foreign");
  std::ofstream(scratch / "foreign/thesis.tex") << "years of work";
  const ProgramRun refused = rigcal("calibrate session --out foreign");
  EXPECT_EQ(refused.code, 3);
  EXPECT_THAT(refused.err, HasSubstr("foreign: the folder holds \"thesis.tex\""));
  EXPECT_EQ(file("foreign/thesis.tex"), "years of work");
  EXPECT_FALSE(fs::exists(scratch / "foreign/extrinsics.yaml"));
}

// Ctrl-C is pending before the program begins, so that it comes during the run however fast or slow the machine is.
TEST_F(Calibrate, EndsWithOneAndWritesNothingAfterCtrlC) {
  const std::string session = (scratch / "session").string();
  const std::string out = (scratch / "stopped").string();
  const std::string said = (scratch / "stopped.txt").string();
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGINT);
    sigprocmask(SIG_BLOCK, &set, nullptr);
    kill(getpid(), SIGINT);  // to the process: what raise() sends waits for this thread only
    if (std::freopen(said.c_str(), "w", stderr) == nullptr) _exit(99);
    execl(RIGCAL_PROGRAM, RIGCAL_PROGRAM, "calibrate", session.c_str(), "--out", out.c_str(), nullptr);
    _exit(99);
  }
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 1) << text_of(said);
  EXPECT_THAT(text_of(said), HasSubstr("stopped before the end, nothing was written"));
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace rigcal
