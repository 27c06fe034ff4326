// `rigcal simulate` as a user runs it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "core/io/extrinsics_file.h"
#include "core/io/ground_truth.h"
#include "core/io/session_folder.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

class Simulate : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun simulate(const std::string& arguments) const {
    return run_rigcal("simulate " + arguments, scratch);
  }
  [[nodiscard]] std::string rig() const {
    return std::string("--rig '") + RIGCAL_SOURCE_DIR + "/config/rigs/turntable.yaml'";
  }
  [[nodiscard]] std::string out(const std::string& name) const { return " --out '" + (scratch / name).string() + "'"; }

  std::filesystem::path scratch = scratch_folder("simulate");
};

TEST_F(Simulate, MakesASessionOfPackets) {
  const ProgramRun run = simulate("room " + rig() + out("s") + " --stops 1 --dwell 0.2 --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto summary = parse_json(run.out);
  EXPECT_TRUE(fits_schema("simulate.json", summary));
  EXPECT_EQ(summary["stops"], 1);
  EXPECT_GT(summary["datagrams"], 5000);  // 1.7 s of 5700 a second
  EXPECT_EQ(summary["images"], 2);
  EXPECT_TRUE(std::filesystem::exists(scratch / "s/images/camera_right/000000.png"));
  const auto session = open_session((scratch / "s").string());
  ASSERT_TRUE(session.has_value());
  EXPECT_FALSE(session->packets.empty());
  EXPECT_FALSE(session->ground_truth.empty());
}

// As where a shell or a batch system limits files (`ulimit -f`).
TEST_F(Simulate, AFileThatMayNotGrowIsAnErrorAndLeavesNothing) {
  rlimit limit{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &limit), 0);
  const rlimit small{1U << 20U, limit.rlim_max};
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const ProgramRun run = simulate("room " + rig() + out("s") + " --stops 1 --dwell 0.2 --images-per-stop 0");
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &limit), 0);
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_THAT(run.err, HasSubstr("File too large"));
  EXPECT_FALSE(std::filesystem::exists(scratch / "s"));
}

TEST_F(Simulate, MountsSensorsWhereTheRigFileSaysWhereNoErrorIsAskedFor) {
  const ProgramRun run = simulate("room " + rig() + out("s") +
                                  " --stops 1 --patches --points 300 --images-per-stop 0 --mount-error 0mm,0deg");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto truth = load_extrinsics((scratch / "s/ground_truth.yaml").string());
  const auto rough = load_extrinsics(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/turntable.yaml");
  ASSERT_TRUE(truth && rough);
  for (const auto& [name, T] : rough->T_base_sensor)
    EXPECT_THAT(truth->T_base_sensor.at(name), SE3Near(T, 1e-9, 1e-9)) << name;
}

TEST_F(Simulate, NamesTheRigFileThatHasNoPackets) {
  const auto refused = [&](const std::string& sensors, const std::string& why) {
    std::ofstream(scratch / "rig.yaml") << "rigcal: 1\nbase: a\nsensors:\n" << sensors;
    const ProgramRun run = simulate("room --rig '" + (scratch / "rig.yaml").string() + "'" + out("s"));
    EXPECT_EQ(run.code, 3);
    EXPECT_THAT(run.err, HasSubstr("rig.yaml: " + why));
  };
  refused("  a: {type: livox_mid40}\n", "sensor 'a' of the rig: has no ip; packets need addresses");
  refused("  a: {type: camera}\n", "has no LiDAR, and nothing else sends packets; add one, or --patches");
}

TEST_F(Simulate, MakesASessionOfPatches) {
  const ProgramRun run = simulate("room " + rig() + out("s") + " --stops 2 --patches --points 300 --images-per-stop 0");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("2 stops"));
  const auto session = open_session((scratch / "s").string());
  ASSERT_TRUE(session.has_value());
  EXPECT_FALSE(session->patches.empty());
}

TEST_F(Simulate, TroublesTheStopsAsAskedFor) {
  const ProgramRun run = simulate("room " + rig() + out("s") +
                                  " --stops 2 --patches --points 300 --images-per-stop 0 --dwell-range 1,3 --creep 0.01"
                                  " --vibration 0.01,25 --overshoot 0.5 --bump 0,0.5,0.1 --bump 1,0.3,0.2");
  EXPECT_EQ(run.code, 0) << run.err;
  const auto truth = load_ground_truth((scratch / "s/ground_truth.yaml").string());
  ASSERT_TRUE(truth) << truth.error().message();
  EXPECT_EQ(truth->stops.size(), 4U) << "each of the two was bumped";
  EXPECT_TRUE(std::filesystem::exists(scratch / "s/patches/avia/3.pcd"));
  const auto refused = [&](const std::string& option) {
    return simulate("room " + rig() + out("r") + " --patches " + option);
  };
  EXPECT_THAT(refused("--bump 1,2").err, HasSubstr("STOP,SECONDS,DEG"));
  EXPECT_EQ(refused("--bump 1,2").code, 2);
  EXPECT_EQ(refused("--vibration 0.1,0").code, 2);
  EXPECT_EQ(refused("--dwell-range 1,2,3").code, 2);
  EXPECT_EQ(refused("--dwell 2 --dwell-range 1,3").code, 2);
  EXPECT_EQ(refused("--creep fast").code, 2);
  EXPECT_EQ(refused("--stops 3 --bump 3,1,1").code, 2);
  EXPECT_THAT(refused("--bump 99,1,1").err, HasSubstr("there is no stop 99: the last one is 19"));
}

TEST_F(Simulate, TurnsByUnequalSteps) {
  const ProgramRun run =
      simulate("room " + rig() + out("s") + " --stops 5 --patches --points 300 --images-per-stop 0 --step-range 50,40");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto truth = load_ground_truth((scratch / "s/ground_truth.yaml").string());
  ASSERT_TRUE(truth) << truth.error().message();
  ASSERT_EQ(truth->stops.size(), 5U);
  for (std::size_t k = 1; k < truth->stops.size(); ++k) {
    const double deg = to_deg(rotation_distance(truth->stops[k - 1].T_G_base.R, truth->stops[k].T_G_base.R));
    EXPECT_GT(deg, 39.9);
    EXPECT_LT(deg, 50.1);
  }
}

// They were taken, and did nothing, or something else.
TEST_F(Simulate, RefusesMotionsThatCannotBe) {
  const auto refused = [&](const std::string& option) {
    const ProgramRun run = simulate("room " + rig() + out("r") + " --patches --stops 3 " + option);
    EXPECT_EQ(run.code, 2) << option;
    return run.err;
  };
  EXPECT_THAT(refused("--bump 1,2,0.1"), HasSubstr("stop 1 ends after 2.0 s"));
  EXPECT_THAT(refused("--bump 0,2.5,0.1"), HasSubstr("stop 0 ends after 2.0 s"));
  EXPECT_THAT(refused("--bump 1,5,0.1 --dwell-range 3,30"), HasSubstr("stop 1 may end after 3.0 s"));
  EXPECT_THAT(refused("--motion vehicle --drive 3"), HasSubstr("only --motion figure8 drives"));
  EXPECT_THAT(refused("--drive 3"), HasSubstr("--motion"));
  EXPECT_THAT(refused("--motion figure8 --step-range 10,60"), HasSubstr("turns as its way does"));
  EXPECT_THAT(refused("--step-range 10"), HasSubstr("LEAST,MOST"));
}

TEST_F(Simulate, HasNoTablesAxisInTheTruthOfADrive) {
  const auto truth = [&](const std::string& name, const std::string& options) {
    const ProgramRun run = simulate("room " + rig() + out(name) + options + " --stops 2 --images-per-stop 0");
    EXPECT_EQ(run.code, 0) << run.err;
    return load_ground_truth((scratch / name / "ground_truth.yaml").string());
  };
  EXPECT_TRUE(truth("turned", " --patches --points 300")->table_axis);
  EXPECT_FALSE(truth("patches", " --patches --points 300 --motion figure8 --drive 1")->table_axis);
  EXPECT_FALSE(truth("packets", " --dwell 0.2 --motion figure8")->table_axis);
}

TEST_F(Simulate, RefusesNumbersThatCannotBeMeant) {
  for (const char* option : {"--seed -1", "--seed 18446744073709551616", "--seed 1.5", "--seed ''",
                             "--mount-error 1e300mm,1deg", "--mount-error 10.1m,1deg", "--mount-error 1mm,181deg"}) {
    const ProgramRun run = simulate("room " + rig() + out("s") + " --patches --points 10 --stops 1 " + option);
    EXPECT_EQ(run.code, 2) << option << run.err;
  }
  EXPECT_FALSE(std::filesystem::exists(scratch / "s"));
}

TEST_F(Simulate, SaysWhatIsWrongAndLeavesNothingBehind) {
  const ProgramRun scene = simulate("moon " + rig() + out("s"));
  EXPECT_EQ(scene.code, 3);
  EXPECT_THAT(scene.err, HasSubstr("courtyard, room, sparse"));
  EXPECT_EQ(simulate("room --rig missing.yaml" + out("s")).code, 3);
  EXPECT_EQ(simulate("room " + rig() + out("s") + " --points 5").code, 2);
  EXPECT_EQ(simulate("room " + rig() + out("s") + " --mount-error 5").code, 2);
  EXPECT_EQ(simulate("room " + rig() + out("s") + " --patches --images-per-stop 2").code, 2);
  EXPECT_FALSE(std::filesystem::exists(scratch / "s"));
}

}  // namespace
}  // namespace rigcal
