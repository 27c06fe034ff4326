// `rigcal export` and `rigcal inspect` as a user runs them, on a simulated run.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/io/ground_truth.h"
#include "core/io/patch_folder.h"
#include "core/io/pcd_file.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;

class Export : public testing::Test {
 protected:
  [[nodiscard]] ProgramRun rigcal(const std::string& arguments) const { return run_rigcal(arguments, scratch); }
  void simulate(const std::string& options) const {
    const ProgramRun run =
        rigcal("simulate room --rig '" + rig_file + "' --out s --quiet --images-per-stop 0 " + options);
    ASSERT_EQ(run.code, 0) << run.err;
  }
  static nlohmann::json parse(const ProgramRun& run) {
    EXPECT_EQ(run.code, 0) << run.err;
    return parse_json(run.out);
  }

  const std::string rig_file = std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/turntable.yaml";
  fs::path scratch = scratch_folder("export");
};

TEST_F(Export, WritesTheStopsOfASessionAsPatchesThatInspectShowsAlike) {
  simulate("--stops 3 --dwell 1.5 --loss 0.01 --duplicate 0.002 --reorder 0.003");
  fs::create_directories(scratch / "s/images/camera_left");
  for (const char* name : {"000000.png", "000001.png"}) {
    std::ofstream(scratch / "s/images/camera_left" / name) << "only counted";
  }
  std::ofstream(scratch / "s/images/camera_left/frames.csv")
      << "file,stamp_ns,trigger,exposure_us,device_stamp,stop\n000000.png,5,,,,\n000001.png,6,,,,\n";
  const auto session = parse(rigcal("inspect s --json"));
  EXPECT_TRUE(fits_schema("inspect.json", session));
  EXPECT_EQ(session["kind"], "session");
  EXPECT_EQ(session["images"]["camera_left"]["files"], 2);
  ASSERT_EQ(session["stops"].size(), 3U);
  ASSERT_EQ(session["devices"].size(), 4U);
  for (const auto& device : session["devices"]) EXPECT_GT(device["control_frames"]["broadcast"], 0);
  EXPECT_THAT(rigcal("inspect s").out, HasSubstr("commands of mid100_left:  broadcast "));

  // What was done to the packets, and what inspect says of it.
  const auto done = load_ground_truth((scratch / "s/ground_truth.yaml").string());
  ASSERT_TRUE(done.has_value());
  for (const auto& device : session["devices"]) {
    auto packets = done->packets.at(device["sensor"].get<std::string>());
    const auto& book = device["point_packets"];
    EXPECT_EQ(book["packets"], packets["point_received"]);
    EXPECT_EQ(book["lost"], packets["point_lost"] - packets["point_lost_at_start"] - packets["point_lost_at_end"]);
    EXPECT_EQ(book["duplicates"], packets["point_duplicated"]);
    EXPECT_EQ(book["out_of_order"], packets["point_out_of_order"]);
    EXPECT_EQ(book["gaps"], packets["point_gaps"]);
    EXPECT_GT(book["lost"], 30);
  }

  const auto summary = parse(rigcal("export s --format patches --out p --json"));
  EXPECT_TRUE(fits_schema("export.json", summary));
  EXPECT_EQ(summary["points"], session["points"]["in_stops"]);
  EXPECT_EQ(summary["files"], 12);

  const auto patches = parse(rigcal("inspect p --json"));
  EXPECT_TRUE(fits_schema("inspect.json", patches));
  EXPECT_THAT(patches["warnings"], IsEmpty());
  ASSERT_EQ(patches["stops"].size(), 3U);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(patches["stops"][k]["points"], session["stops"][k]["points"]);

  // The rotations between the stops, against the truth: the gyro's scale is off by 5e-4, 120 degrees by 0.06.
  const auto rig = load_rig((scratch / "p/rig.yaml").string());
  ASSERT_TRUE(rig.has_value());
  const auto folder = list_patch_folder((scratch / "p").string(), *rig);
  ASSERT_TRUE(folder.has_value() && folder->trajectory.has_value());
  const auto truth = load_ground_truth((scratch / "s/ground_truth.yaml").string());
  ASSERT_TRUE(truth.has_value());
  ASSERT_EQ(truth->stops.size(), 3U);
  for (const StopTruth& stop : truth->stops) {
    const SE3& pose = folder->trajectory->at(stop.stop.index);
    EXPECT_LT(to_deg(rotation_distance(pose.R, stop.T_G_base.R)), 0.25);
    EXPECT_EQ(pose.t, Vector3d::Zero());
  }

  const ProgramRun clouds = rigcal("export s/lidar.pcapng --rig '" + rig_file + "' --format pcd --out c");
  EXPECT_EQ(clouds.code, 0) << clouds.err;
  const auto cloud = read_pcd((scratch / "c/avia_2.pcd").string());
  const auto patch = read_pcd((scratch / "p/avia/2.pcd").string());
  ASSERT_TRUE(cloud.has_value() && patch.has_value());
  EXPECT_EQ(cloud->points.size(), patch->points.size());

  const auto las_summary = parse(rigcal("export s --format las --out l --json"));
  EXPECT_TRUE(fits_schema("export.json", las_summary));
  EXPECT_EQ(las_summary["points"], session["points"]["in_stops"]);
  const std::string las = text_of(scratch / "l/avia_2.las");
  EXPECT_EQ(las.size(), 375 + 28 * patch->points.size());
  const auto seconds_after_start = [&](double time_s) {
    return time_s - 1e-9 * static_cast<double>(session["stops"][2]["start_ns"].get<std::int64_t>());
  };
  const double length_s = session["stops"][2]["seconds"].get<double>();
  double gps_s = 0.0;
  std::memcpy(&gps_s, las.data() + 375 + 28 * 1000 + 20, sizeof gps_s);
  EXPECT_GT(seconds_after_start(gps_s + 1e9 + 315964800.0 - 18.0), -1e-3);
  EXPECT_LT(seconds_after_start(gps_s + 1e9 + 315964800.0 - 18.0), length_s);
  const std::string pcd = text_of(scratch / "c/avia_2.pcd");
  EXPECT_THAT(pcd.substr(0, 300), HasSubstr("FIELDS x y z intensity tag timestamp"));
  double last_s = 0.0;
  std::memcpy(&last_s, pcd.data() + pcd.size() - sizeof last_s, sizeof last_s);
  EXPECT_GT(seconds_after_start(last_s), 0.9 * length_s);
  EXPECT_LT(seconds_after_start(last_s), length_s + 1e-3);

  const auto dump = parse(rigcal("inspect s/lidar.pcapng --json"));
  EXPECT_TRUE(fits_schema("inspect.json", dump));
  EXPECT_EQ(dump["kind"], "dump");
  EXPECT_FALSE(dump.contains("stops"));
  EXPECT_THAT(json_text(dump["warnings"]), Not(HasSubstr("rig file"))) << "none was given";
  EXPECT_EQ(rigcal("export s --format patches --out p").code, 3) << "never over what is there";
}

TEST_F(Export, SaysWhatIsWrongAndLeavesNothingBehind) {
  simulate("--stops 1 --dwell 0.1");
  const std::string packets = (scratch / "s/lidar.pcapng").string();
  EXPECT_EQ(rigcal("export s/lidar.pcapng --format patches --out p").code, 3);
  EXPECT_EQ(rigcal("export nothing --rig '" + rig_file + "' --format patches --out p").code, 3);
  EXPECT_EQ(rigcal("export s --format kml --out p").code, 2);
  std::ofstream(scratch / "noise.pcap") << "this is no dump, but it is long enough to be looked at";
  for (const char* command : {"inspect noise.pcap", "inspect missing", "inspect ."}) {
    const ProgramRun run = rigcal(command);
    EXPECT_EQ(run.code, 3) << command;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
  }
  // A dump that is cut in the middle of a packet: what is whole is shown, and the exit code says so.
  fs::resize_file(packets, fs::file_size(packets) - 100);
  const ProgramRun cut = rigcal("inspect s --json");
  EXPECT_EQ(cut.code, 1) << cut.err;
  EXPECT_EQ(parse_json(cut.out)["complete"], false);
  EXPECT_FALSE(fs::exists(scratch / "p"));
}

// What a pipe gave it does not give again.
TEST_F(Export, FilesMayComeThroughPipes) {
  simulate("--stops 1 --dwell 1");
  const std::string rig = text_of(scratch / "s/rig.yaml");
  const std::string from_pipe = " s/lidar.pcapng --rig /dev/stdin --out ";
  const ProgramRun imported = run_rigcal("import" + from_pipe + "i", scratch, "cat s/rig.yaml");
  EXPECT_EQ(imported.code, 0) << imported.err;
  EXPECT_EQ(text_of(scratch / "i/rig.yaml"), rig);
  const ProgramRun exported = run_rigcal("export --format patches" + from_pipe + "e", scratch, "cat s/rig.yaml");
  EXPECT_EQ(exported.code, 0) << exported.err;
  EXPECT_EQ(text_of(scratch / "e/rig.yaml"), rig);
  const ProgramRun inspected = run_rigcal("inspect /dev/stdin --json", scratch, "cat s/lidar.pcapng");
  EXPECT_EQ(parse(inspected)["devices"], parse(rigcal("inspect s/lidar.pcapng --json"))["devices"]);
  const ProgramRun no_dump = run_rigcal("inspect /dev/stdin", scratch, "cat s/rig.yaml");
  EXPECT_EQ(no_dump.code, 3);
  EXPECT_THAT(no_dump.err, HasSubstr("is no packet dump, and a pipe can give nothing else; save it to a file first"));
  const ProgramRun calibrated = run_rigcal("calibrate" + from_pipe + "r", scratch, "cat s/rig.yaml");
  EXPECT_LE(calibrated.code, 1) << calibrated.err;
  EXPECT_EQ(calibrated.code, rigcal("calibrate s --out f").code);
  EXPECT_EQ(text_of(scratch / "r/extrinsics.yaml"), text_of(scratch / "f/extrinsics.yaml"));
}

TEST_F(Export, NamesThatAreNoUtf8AreShownWithAReplacement) {
  const fs::path folder = scratch / "b\xFCro";
  fs::create_directories(folder / "image" / "left");
  std::ofstream(folder / "image" / "left" / "0.png") << "only counted";
  EXPECT_EQ(parse(rigcal("inspect 'b\xFCro' --json"))["path"], "b\xEF\xBF\xBDro");
  simulate("--stops 1 --dwell 0.6 --patches");
  const auto imported = parse(rigcal("import s/patches --rig s/rig.yaml --out 'n\xFC' --json"));
  EXPECT_EQ(imported["out"], "n\xEF\xBF\xBD");
}

TEST_F(Export, InspectShowsAResult) {
  std::ofstream(scratch / "extrinsics.yaml")
      << "rigcal: 1\nbase: a\nsensors:\n  a: {status: good, translation: [0, 0, 0], rotation_xyzw: [0, 0, 0, 1]}\n"
         "  b: {status: weak, translation: [1, 2, 3], rotation_xyzw: [0, 0, 0, 1]}\n  c: {status: failed}\n";
  const ProgramRun run = rigcal("inspect . --json");
  EXPECT_EQ(run.code, 1) << "not all of it is good";
  const auto result = parse_json(run.out);
  EXPECT_TRUE(fits_schema("inspect.json", result));
  ASSERT_EQ(result["sensors"].size(), 3U);
  EXPECT_EQ(result["sensors"][1]["translation"][2], 3.0);
  EXPECT_FALSE(result["sensors"][2].contains("translation"));
  EXPECT_THAT(rigcal("inspect extrinsics.yaml").out, HasSubstr("weak"));
}

}  // namespace
}  // namespace rigcal
