// ROS 1 bags as a user gives them to rigcal: one simulated run of an AVIA and a MID-40, as packets and as a bag.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "core/io/extrinsics_file.h"
#include "core/io/pcd_file.h"
#include "tests/apps/commands/bag_recording.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/se3_matchers.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

const std::string rig_yaml = small_rig();

class Bag : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("bag");
    std::ofstream(scratch / "rig.yaml") << rig_yaml;
    simulate_courtyard(rig_yaml, hurried_run(8, 1.1), scratch / "session");
    whole = bag_of_dump((scratch / "session/lidar.pcapng").string(), 21).finish();
    write("run.bag", whole);
    from_session = rigcal("calibrate session --out from_session --quiet");
    from_bag = rigcal("calibrate run.bag --rig rig.yaml --out from_bag --quiet");
    inspected = rigcal("inspect run.bag --rig rig.yaml --json");
  }

  static void write(const std::string& name, const BagBytes::Bytes& bytes) { save_bytes(scratch / name, bytes); }
  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  static SE3 mid40(const std::string& result) {
    const auto loaded = load_extrinsics((scratch / result).string());
    EXPECT_TRUE(loaded.has_value() && loaded->T_base_sensor.count("mid40") == 1) << result;
    return loaded && loaded->T_base_sensor.count("mid40") == 1 ? loaded->T_base_sensor.at("mid40") : SE3{};
  }
  static std::string file(const std::string& name) { return text_of(scratch / name); }
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
  static inline ProgramRun from_session, from_bag, inspected;
};

TEST_F(Bag, GivesTheExtrinsicsThatThePacketsGive) {
  ASSERT_LE(from_session.code, 1) << from_session.err;
  EXPECT_EQ(from_bag.code, from_session.code) << from_bag.err;
  EXPECT_THAT(mid40("from_bag/extrinsics.yaml"), SE3Near(mid40("from_session/extrinsics.yaml"), 0.02, 2.0));
}

TEST_F(Bag, IsInspectedWithAndWithoutARig) {
  const ProgramRun plain = rigcal("inspect run.bag --json");
  ASSERT_EQ(plain.code, 0) << plain.err;
  const auto topics = parse_json(plain.out);
  EXPECT_TRUE(fits_schema("inspect.json", topics));
  EXPECT_EQ(topics["kind"], "bag");
  ASSERT_EQ(topics["topics"].size(), 3U);
  EXPECT_EQ(topics["topics"][0]["topic"], "/livox/imu_179");
  EXPECT_NEAR(topics["topics"][0]["messages_per_s"].get<double>(), 200.0, 2.0);
  EXPECT_FALSE(topics["topics"][0].contains("sensor"));

  ASSERT_EQ(inspected.code, 0) << inspected.err;
  const auto full = parse_json(inspected.out);
  EXPECT_TRUE(fits_schema("inspect.json", full));
  EXPECT_EQ(full["stops"].size(), 8U);
  EXPECT_EQ(full["topics"][1]["sensor"], "avia");
  EXPECT_EQ(full["topics"][1]["untimed"], 0);
  EXPECT_GT(full["topics"][1]["points"].get<int>(), 100'000);
  EXPECT_EQ(full["topics"][2]["lost"], 0);
  EXPECT_THAT(rigcal("inspect run.bag --rig rig.yaml").out, HasSubstr("a bag"));
}

TEST_F(Bag, CompressedOrCutIsReadAlike) {
  write("small.bag", bag_of_dump((scratch / "session/lidar.pcapng").string(), 21, "lz4").finish());
  const ProgramRun small = rigcal("inspect small.bag --rig rig.yaml --json");
  EXPECT_EQ(small.out.find("\"malformed\": 1"), std::string::npos);
  EXPECT_EQ(parse_json(small.out)["points"], parse_json(inspected.out)["points"]);
  BagBytes::Bytes half(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(whole.size() / 2));
  write("half.bag", half);
  const ProgramRun cut = rigcal("inspect half.bag --rig rig.yaml --json");
  EXPECT_EQ(cut.code, 1) << cut.err;
  EXPECT_THAT(cut.err, HasSubstr("has no whole index"));
  const auto json = parse_json(cut.out);
  EXPECT_EQ(json["complete"], false);
  EXPECT_GE(json["stops"].size(), 3U);
  EXPECT_LE(json["stops"].size(), 5U);
}

TEST_F(Bag, IsImportedWithEveryPointOfItsStopsAndItsImages) {
  BagBytes bytes = bag_of_dump((scratch / "session/lidar.pcapng").string(), 21, "lz4");
  const auto stops = parse_json(inspected.out)["stops"];
  const auto in_stop_ns = (stops[2]["start_ns"].get<std::int64_t>() + stops[2]["end_ns"].get<std::int64_t>()) / 2;
  const auto moving_ns = (stops[2]["end_ns"].get<std::int64_t>() + stops[3]["start_ns"].get<std::int64_t>()) / 2;
  const RosBytes jpeg{0xFF, 0xD8, 0xFF, 0xE0, 1, 2, 3};
  bytes.add("/cam", compressed_type, compressed_md5, in_stop_ns,
            compressed_message(0, in_stop_ns - 5, "bayer_rggb8; jpeg compressed", jpeg));
  bytes.add("/cam", compressed_type, compressed_md5, moving_ns,
            compressed_message(1, moving_ns - 5, "tiff", {'I', 'I', 42, 0}));
  bytes.add("/raw", image_type, image_md5, moving_ns,
            image_message(0, 0, 3, 2, "bayer_rggb8", 4, {1, 2, 3, 0, 4, 5, 6, 0}));
  write("images.bag", bytes.finish());
  rig_with("initial_extrinsics:",
           "  cam: {type: camera, topic: /cam}\n  raw: {type: camera, topic: raw, pixel_format: "
           "BayerRG8}\ninitial_extrinsics:");
  const ProgramRun run = rigcal("import images.bag --rig changed.yaml --out imported --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("cam: 1 images are of an encoding that is not known (tiff)"));
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("import.json", json));
  EXPECT_EQ(json["kind"], "bag");
  EXPECT_EQ(json["stops"], 8);
  EXPECT_EQ(json["images"], 2);
  EXPECT_EQ(file("imported/rig.yaml"), file("changed.yaml"));
  EXPECT_EQ(file("imported/images/cam/000000.jpg"), std::string(jpeg.begin(), jpeg.end()));
  EXPECT_THAT(file("imported/images/cam/frames.csv"),
              HasSubstr("000000.jpg," + std::to_string(in_stop_ns) + ",,," + std::to_string(in_stop_ns - 5) + ",2\n"));
  EXPECT_THAT(file("imported/images/raw/frames.csv"), HasSubstr("000000.png," + std::to_string(moving_ns) + ",,,,\n"));
  EXPECT_THAT(file("imported/images/raw/000000.png"), HasSubstr("IHDR"));

  ASSERT_EQ(rigcal("export run.bag --rig rig.yaml --format patches --out exported").code, 0);
  for (const char* cloud : {"avia/0.pcd", "avia/7.pcd", "mid40/3.pcd"}) {
    EXPECT_TRUE(file(std::string("imported/patches/") + cloud) == file(std::string("exported/") + cloud)) << cloud;
  }
  EXPECT_TRUE(file("imported/trajectory.tum") == file("exported/trajectory.tum"));
  ASSERT_LE(rigcal("calibrate imported --out from_imported --quiet").code, 1);
  // The rotations between the stops have gone through a trajectory: the starts are micrometres apart, so that a cell or
  // two of 300 000 may fall into another voxel. Sigma is 0.6 mm.
  EXPECT_THAT(mid40("from_imported/extrinsics.yaml"), SE3Near(mid40("from_bag/extrinsics.yaml"), 2e-5, 0.02));
}

TEST_F(Bag, AMosaicIsNamedInTheImportedRigFile) {
  BagBytes bytes = bag_of_dump((scratch / "session/lidar.pcapng").string(), 21, "lz4");
  const auto stops = parse_json(inspected.out)["stops"];
  const auto in_stop_ns = (stops[2]["start_ns"].get<std::int64_t>() + stops[2]["end_ns"].get<std::int64_t>()) / 2;
  for (const auto& [topic, encoding] :
       {std::pair{"/silent", "bayer_gbrg8"}, {"/wrong", "bayer_rggb8"}, {"/right", "bayer_bggr8"}, {"/grey", "mono8"}})
    bytes.add(topic, image_type, image_md5, in_stop_ns, image_message(0, 0, 2, 2, encoding, 2, {1, 2, 3, 4}));
  write("mosaics.bag", bytes.finish());
  rig_with("initial_extrinsics:",
           "  silent: {type: camera, topic: /silent}\n"
           "  wrong: {type: camera, topic: /wrong, pixel_format: BayerGR8}\n"
           "  right: {type: camera, topic: /right, pixel_format: BayerBG8}\n"
           "  grey: {type: camera, topic: /grey}\ninitial_extrinsics:");
  const ProgramRun run = rigcal("import mosaics.bag --rig changed.yaml --out mosaics");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("silent: its images are BayerGB8, which the rig file does not say"));
  EXPECT_THAT(run.err, HasSubstr("rig.yaml beside them has pixel_format: BayerRG8"));
  ASSERT_EQ(rigcal("export mosaics.bag --rig changed.yaml --format patches --out mosaic_patches").code, 0);
  EXPECT_TRUE(fs::exists(scratch / "mosaic_patches/image/silent/2.png"));
  for (const char* folder : {"mosaics", "mosaic_patches"}) {
    const auto rig = load_rig((scratch / folder / "rig.yaml").string());
    ASSERT_TRUE(rig) << rig.error().message();
    const auto format = [&](const char* name) {
      return rig->sensors[static_cast<std::size_t>(rig->find(name))].camera->pixel_format;
    };
    EXPECT_EQ(format("silent"), "BayerGB8");
    EXPECT_EQ(format("wrong"), "BayerRG8");
    EXPECT_EQ(format("right"), "BayerBG8");
    EXPECT_EQ(format("grey"), "");
  }
}

TEST_F(Bag, ADumpIsImportedToTheLastDatagram) {
  // With the session's own rig file, whose quaternions were rounded as it was written.
  const ProgramRun run = rigcal("import session/lidar.pcapng --rig session/rig.yaml --out again --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto json = parse_json(run.out);
  EXPECT_TRUE(fits_schema("import.json", json));
  EXPECT_TRUE(file("again/lidar.pcapng") == file("session/lidar.pcapng")) << "it was a session's dump";
  const auto record = parse_json(file("again/session.json"));
  const auto original = parse_json(file("session/session.json"));
  EXPECT_EQ(record["counters"]["avia"]["packets"], original["counters"]["avia"]["packets"]);
  EXPECT_TRUE(record["end_ns"].is_number_integer());
  EXPECT_EQ(file("again/rig.yaml"), file("session/rig.yaml"));

  const ProgramRun twice = rigcal("import session/lidar.pcapng --rig rig.yaml --out again");
  EXPECT_EQ(twice.code, 3) << "a session is never overwritten";
  EXPECT_TRUE(fs::exists(scratch / "again/lidar.pcapng"));
  fs::copy_file(scratch / "session/lidar.pcapng", scratch / "cut.pcapng");
  fs::resize_file(scratch / "cut.pcapng", fs::file_size(scratch / "cut.pcapng") - 77);
  EXPECT_EQ(rigcal("import cut.pcapng --rig rig.yaml --out cut").code, 1);
  EXPECT_EQ(rigcal("inspect cut").code, 1) << "as the dump itself would be";
}

TEST_F(Bag, PatchesAreImportedAsTheyAre) {
  ASSERT_EQ(rigcal("export session --format patches --out folder").code, 0);
  const ProgramRun run = rigcal("import folder --out of_patches --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(parse_json(run.out)["kind"], "patches");
  for (const std::string sensor : {"avia", "mid40"}) {
    for (int stop = 0; stop < 8; ++stop) {
      const std::string cloud = sensor + "/" + std::to_string(stop) + ".pcd";
      EXPECT_TRUE(file("of_patches/patches/" + cloud) == file("folder/" + cloud)) << cloud;
    }
  }
  EXPECT_FALSE(file("folder/trajectory.tum").empty());
  EXPECT_TRUE(file("of_patches/trajectory.tum") == file("folder/trajectory.tum"));
  EXPECT_EQ(file("of_patches/rig.yaml"), file("folder/rig.yaml"));
  const auto stops_of = [](const std::string& name) {
    return parse_json(rigcal("inspect " + name + " --json").out)["stops"];
  };
  EXPECT_EQ(stops_of("of_patches").size(), 8U);
  EXPECT_EQ(stops_of("of_patches"), stops_of("folder")) << "and they are read from where they are now";
}

TEST_F(Bag, NothingIsLeftOfAnImportThatFails) {
  const auto refused = [](const std::string& arguments, const std::string& why) {
    const ProgramRun run = rigcal("import " + arguments + " --out failed");
    EXPECT_EQ(run.code, 3) << run.err;
    EXPECT_THAT(run.err, HasSubstr(why));
    EXPECT_FALSE(fs::exists(scratch / "failed"));
  };
  refused("run.bag", "add --rig");
  refused("missing.bag --rig rig.yaml", "no such file");
  refused("session", "is a session already");
  refused("run.bag --rig " + rig_with("/livox/imu_179", "/imu"), "has no topic /imu");
  std::ofstream(scratch / "text.txt") << "neither a dump nor a bag, but some bytes to look at";
  refused("text.txt --rig rig.yaml", "text.txt");
  for (const auto& entry : fs::directory_iterator(scratch)) {
    EXPECT_EQ(entry.path().filename().string().find("failed"), std::string::npos) << entry.path();
  }
}

TEST_F(Bag, NamesTopicsThatAreNotThereTheNearestFirst) {
  expect_refused(
      "run.bag", rig_with("/livox/lidar_179", "/livox/lidar_178"),
      {"run.bag: has no topic /livox/lidar_178 (avia); there are /livox/lidar_179 (livox_ros_driver/CustomMsg)",
       "correct the topic"});
  expect_refused("run.bag", rig_with(", topic: livox/lidar_21", ""), {"does not say which topic is mid40"});
  expect_refused("run.bag", rig_with("livox/lidar_21", "livox/lidar_179"),
                 {"changed.yaml:", "sensors.mid40.topic is livox/lidar_179, which another sensor has"});
  expect_refused("run.bag", rig_with("imu_topic: /livox/imu_179", "imu_topic: /imu"), {"has no topic /imu (avia)"});
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
