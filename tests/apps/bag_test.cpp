// ROS 1 bags as a user gives them to rigcal: one simulated run of an AVIA and a MID-40, as packets and as a bag.
#include <gmock/gmock.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/io/extrinsics_file.h"
#include "core/io/pcd_file.h"
#include "simdata/scene_file.h"
#include "simdata/session_writer.h"
#include "tests/apps/bag_recording.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;

constexpr const char* rig_yaml = R"(rigcal: 1
name: test
base: avia
sensors:
  avia: {type: livox_avia, ip: 192.168.1.179, topic: /livox/lidar_179, imu_topic: /livox/imu_179}
  mid40: {type: livox_mid40, ip: 192.168.1.21, topic: livox/lidar_21}
initial_extrinsics:
  mid40: {translation: [-0.15, 0.0, -0.15], rotation_xyzw: [0.0, 0.0, -0.965926, 0.258819]}
)";

class Bag : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = fs::path(testing::TempDir()) / ("rigcal_bag_" + std::to_string(getpid()));
    fs::remove_all(scratch);
    fs::create_directories(scratch);
    std::ofstream(scratch / "rig.yaml") << rig_yaml;
    const auto rig = parse_rig(rig_yaml, "rig.yaml");
    const auto scene = sim::load_scene("courtyard");
    ASSERT_TRUE(rig.has_value() && scene.has_value());
    sim::RunOptions run;
    run.turntable.stops = 8;
    run.turntable.dwell_s = 1.1;
    run.turntable.turn_s = 0.5;
    run.turntable.swing_rad = 2e-4;
    run.turntable.initial_still_s = 1.0;
    SilentReporter silent;
    ASSERT_TRUE(sim::simulate_session(*scene, *rig, run, (scratch / "session").string(), {silent}).has_value());
    whole = bag_of_dump((scratch / "session/lidar.pcapng").string(), 21).finish();
    write("run.bag", whole);
  }
  static void TearDownTestSuite() { fs::remove_all(scratch); }

  static void write(const std::string& name, const BagBytes::Bytes& bytes) {
    std::ofstream(scratch / name, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
  }
  static ProgramRun rigcal(const std::string& arguments) {
    return run_program("cd '" + scratch.string() + "' && '" + RIGCAL_PROGRAM + "' " + arguments, scratch);
  }
  static SE3 mid40(const std::string& result) {
    const auto loaded = load_extrinsics((scratch / result).string());
    EXPECT_TRUE(loaded.has_value() && loaded->T_base_sensor.count("mid40") == 1) << result;
    return loaded && loaded->T_base_sensor.count("mid40") == 1 ? loaded->T_base_sensor.at("mid40") : SE3{};
  }
  /// The rig file with a part of its text replaced.
  static std::string rig_with(const std::string& part, const std::string& other) {
    std::string text = rig_yaml;
    text.replace(text.find(part), part.size(), other);
    std::ofstream(scratch / "changed.yaml") << text;
    return "changed.yaml";
  }
  static void expect_refused(const std::string& input, const std::string& rig, const std::vector<std::string>& parts) {
    const ProgramRun run = rigcal("calibrate " + input + " --rig " + rig + " --out refused --quiet");
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    for (const std::string& part : parts) EXPECT_THAT(run.err, HasSubstr(part));
    EXPECT_FALSE(fs::exists(scratch / "refused"));
  }

  static inline fs::path scratch;
  static inline BagBytes::Bytes whole;
};

TEST_F(Bag, GivesTheExtrinsicsThatThePacketsGive) {
  const ProgramRun from_packets = rigcal("calibrate session --out a --quiet");
  const ProgramRun from_bag = rigcal("calibrate run.bag --rig rig.yaml --out b --quiet");
  ASSERT_LE(from_packets.code, 1) << from_packets.err;
  EXPECT_EQ(from_bag.code, from_packets.code) << from_bag.err;
  EXPECT_THAT(mid40("b/extrinsics.yaml"), SE3Near(mid40("a/extrinsics.yaml"), 0.02, 2.0));
}

TEST_F(Bag, IsInspectedWithAndWithoutARig) {
  const ProgramRun plain = rigcal("inspect run.bag --json");
  ASSERT_EQ(plain.code, 0) << plain.err;
  const auto topics = nlohmann::json::parse(plain.out);
  EXPECT_THAT(SchemaCheck("inspect.json").violations(topics), IsEmpty());
  EXPECT_EQ(topics["kind"], "bag");
  ASSERT_EQ(topics["topics"].size(), 3U);
  EXPECT_EQ(topics["topics"][0]["topic"], "/livox/imu_179");
  EXPECT_NEAR(topics["topics"][0]["messages_per_s"].get<double>(), 200.0, 2.0);
  EXPECT_FALSE(topics["topics"][0].contains("sensor"));

  const ProgramRun with_rig = rigcal("inspect run.bag --rig rig.yaml --json");
  ASSERT_EQ(with_rig.code, 0) << with_rig.err;
  const auto full = nlohmann::json::parse(with_rig.out);
  EXPECT_THAT(SchemaCheck("inspect.json").violations(full), IsEmpty());
  EXPECT_EQ(full["stops"].size(), 8U);
  EXPECT_EQ(full["topics"][1]["sensor"], "avia");
  EXPECT_EQ(full["topics"][1]["untimed"], 0);
  EXPECT_GT(full["topics"][1]["points"].get<int>(), 100'000);
  EXPECT_EQ(full["topics"][2]["lost"], 0);
  EXPECT_THAT(rigcal("inspect run.bag --rig rig.yaml").out, HasSubstr("a bag"));
}

TEST_F(Bag, CompressedOrCutIsReadAlike) {
  write("small.bag", bag_of_dump((scratch / "session/lidar.pcapng").string(), 21, "lz4").finish());
  EXPECT_EQ(rigcal("inspect small.bag --rig rig.yaml --json").out.find("\"malformed\": 1"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(rigcal("inspect small.bag --rig rig.yaml --json").out)["points"],
            nlohmann::json::parse(rigcal("inspect run.bag --rig rig.yaml --json").out)["points"]);
  BagBytes::Bytes half(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
  write("half.bag", half);
  const ProgramRun cut = rigcal("inspect half.bag --rig rig.yaml --json");
  EXPECT_EQ(cut.code, 1) << cut.err;
  EXPECT_THAT(cut.err, HasSubstr("has no whole index"));
  const auto json = nlohmann::json::parse(cut.out);
  EXPECT_EQ(json["complete"], false);
  EXPECT_GE(json["stops"].size(), 3U);
  EXPECT_LE(json["stops"].size(), 5U);
}

TEST_F(Bag, NamesTopicsThatAreNotThereTheNearestFirst) {
  expect_refused(
      "run.bag", rig_with("/livox/lidar_179", "/livox/lidar_178"),
      {"run.bag: has no topic /livox/lidar_178 (avia); there are /livox/lidar_179 (livox_ros_driver/CustomMsg)",
       "correct the topic"});
  expect_refused("run.bag", rig_with(", topic: livox/lidar_21", ""), {"does not say which topic is mid40"});
  expect_refused("run.bag", rig_with("livox/lidar_21", "livox/lidar_179"), {"to both avia and mid40"});
  expect_refused("run.bag", rig_with(", imu_topic: /livox/imu_179", ", imu_topic: /imu"), {"has no topic /imu (avia)"});
  expect_refused("half_missing.bag", "rig.yaml", {"half_missing.bag"});
  expect_refused("run.bag", "missing.yaml", {"missing.yaml"});
}

TEST_F(Bag, NamesTopicsOfAnotherType) {
  BagBytes strings;
  strings.add("/livox/lidar_179", "std_msgs/String", "992ce8a1687cec8c8bd883ec73ca41d1", 1, {});
  strings.add("/livox/imu_179", imu_type, imu_md5, 1, {});
  strings.add("/livox/lidar_21", cloud_type, cloud_md5, 1, {});
  write("strings.bag", strings.finish());
  expect_refused("strings.bag", "rig.yaml", {"of avia carries std_msgs/String, not livox_ros_driver/CustomMsg"});
  BagBytes versions;
  versions.add("/livox/lidar_179", livox_type, imu_md5, 1, {});
  versions.add("/livox/imu_179", imu_type, imu_md5, 1, {});
  versions.add("/livox/lidar_21", cloud_type, cloud_md5, 1, {});
  write("versions.bag", versions.finish());
  expect_refused("versions.bag", "rig.yaml", {"in another version (md5sum " + std::string(imu_md5)});
  BagBytes empty;
  empty.add("/livox/lidar_179", livox_type, livox_md5, 1, {});
  empty.add("/livox/imu_179", imu_type, imu_md5, 1, {});
  empty.add("/livox/lidar_21", cloud_type, cloud_md5, 1, {});
  write("faulty.bag", empty.finish());
  expect_refused("faulty.bag", "rig.yaml", {"has no usable point: a message is cut"});
}

}  // namespace
}  // namespace rigcal
