// A camera beside every kind of recording: one simulated run of an AVIA, a MID-40 and a small camera, as a session of
// packets, as a dump and as an .lvx file with the images in a folder, and as a bag.
#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>

#include "core/io/extrinsics_file.h"
#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "tests/apps/commands/bag_recording.h"
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
using testing::HasSubstr;

constexpr int stops = 8;
const std::string rig_yaml =
    small_rig(small_camera("left", "BayerRG8"),
              "  left: {translation: [0.05, 0.06, -0.05], rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}\n");

class CameraInputs : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("camera_inputs");
    sim::RunOptions run = hurried_run(stops, 1.1);
    run.mount_error = {0.02, 1.0};
    run.images_per_stop = 1;
    simulate_courtyard(rig_yaml, run, scratch / "session");
    of_session = found_from("session");
  }

  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  static std::string dump() { return (scratch / "session/lidar.pcapng").string(); }
  static std::vector<FrameRecord> frames() {
    const auto read = read_frames((scratch / "session/images/left/frames.csv").string());
    EXPECT_TRUE(read && read->size() == stops);
    return read ? *read : std::vector<FrameRecord>{};
  }
  static fs::path image(const FrameRecord& frame) { return scratch / "session/images/left" / frame.file; }

  /// Calibrates, and expects the camera where the truth has it; a pixel is 2.3 mrad here, 2 cm in 10 m.
  static SE3 found_from(const std::string& arguments) {
    const ProgramRun run = rigcal("calibrate " + arguments + " --out result --quiet");
    EXPECT_LE(run.code, 1) << run.err;
    const auto got = load_extrinsics((scratch / "result/extrinsics.yaml").string());
    const auto truth = load_extrinsics((scratch / "session/ground_truth.yaml").string());
    if (!got || !truth || got->T_base_sensor.count("left") == 0) {
      ADD_FAILURE() << arguments << ": the camera was not found: " << run.out << run.err;
      return {};
    }
    const SE3& T = got->T_base_sensor.at("left");
    EXPECT_LT((T.t - truth->T_base_sensor.at("left").t).norm(), 0.06) << arguments;
    EXPECT_LT(to_deg(rotation_distance(T.R, truth->T_base_sensor.at("left").R)), 0.4) << arguments;
    EXPECT_EQ(json_of_file(scratch / "result/report.json")["cameras"][0]["images"].size(), std::size_t{stops})
        << arguments;
    return T;
  }

  static inline fs::path scratch;
  static inline SE3 of_session;
};

TEST_F(CameraInputs, PacketsOfASessionAndADumpWithAFolderOfImagesGiveTheSame) {
  const SE3 of_dump = found_from("session/lidar.pcapng --rig session/rig.yaml --images session/images");
  EXPECT_EQ(of_session.matrix(), of_dump.matrix()) << "to the bit";
}

TEST_F(CameraInputs, AnImportedDumpTakesItsImagesAlong) {
  const ProgramRun run =
      rigcal("import session/lidar.pcapng --rig session/rig.yaml --images session/images --out imported --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_TRUE(fits_schema("import.json", parse_json(run.out)));
  EXPECT_EQ(parse_json(run.out)["images"], stops);
  EXPECT_EQ(text_of(scratch / "imported/images/left/frames.csv"), text_of(scratch / "session/images/left/frames.csv"));
  EXPECT_EQ(of_session.matrix(), found_from("imported").matrix()) << "to the bit";
}

TEST_F(CameraInputs, ImagesNamedByTheirStampsGetATableOfFrames) {
  const fs::path folder = scratch / "stamped/left";
  fs::create_directories(folder);
  for (const FrameRecord& frame : frames())
    fs::copy_file(image(frame), folder / (std::to_string(frame.stamp_ns) + ".png"));
  std::ofstream(folder / "notes.txt") << "clouded over";
  const ProgramRun run = rigcal("import session/lidar.pcapng --rig session/rig.yaml --images stamped --out of_stamps");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("1 files are not used, since they are neither .png nor .jpg, the first: notes.txt"));
  EXPECT_THAT(run.out, HasSubstr(", 8 images"));
  const auto imported = read_frames((scratch / "of_stamps/images/left/frames.csv").string());
  ASSERT_TRUE(imported) << imported.error().message();
  ASSERT_EQ(imported->size(), std::size_t{stops});
  EXPECT_EQ(imported->front().stamp_ns, frames().front().stamp_ns);
  EXPECT_EQ(text_of(scratch / "of_stamps/images/left" / imported->front().file), text_of(image(frames().front())));
}

TEST_F(CameraInputs, AnImportWithoutImagesSaysSo) {
  const std::string dump_of_rig = "import session/lidar.pcapng --rig session/rig.yaml";
  const ProgramRun without = rigcal(dump_of_rig + " --out blind");
  EXPECT_EQ(without.code, 0);
  EXPECT_THAT(without.err, HasSubstr("left: no image of it is written"));
  EXPECT_THAT(without.err, HasSubstr("give them by --images DIR"));
  EXPECT_FALSE(fs::exists(scratch / "blind/images"));

  const ProgramRun nowhere = rigcal(dump_of_rig + " --images nowhere --out refused");
  EXPECT_EQ(nowhere.code, 3);
  EXPECT_THAT(nowhere.err, HasSubstr("no such folder"));
  fs::create_directories(scratch / "damaged/left");
  std::ofstream(scratch / "damaged/left/frames.csv") << "file,stamp\n";
  const ProgramRun damaged = rigcal(dump_of_rig + " --images damaged --out refused");
  EXPECT_EQ(damaged.code, 3);
  EXPECT_THAT(damaged.err, HasSubstr("frames.csv"));
  for (const auto& entry : fs::directory_iterator(scratch))
    EXPECT_EQ(entry.path().filename().string().find("refused"), std::string::npos) << entry.path();
}

TEST_F(CameraInputs, ImportedPatchesTakeImagesOfTheirStops) {
  ASSERT_EQ(rigcal("export session --format patches --out bare").code, 0);
  fs::rename(scratch / "bare/image", scratch / "by_stop");
  ASSERT_EQ(rigcal("import bare --images by_stop --out of_bare").code, 0);
  EXPECT_EQ(text_of(scratch / "of_bare/images/left/0.png"), text_of(scratch / "by_stop/left/0.png"));
  EXPECT_FALSE(fs::exists(scratch / "of_bare/images/left/frames.csv")) << "stamps are not known";
  found_from("of_bare");
}

TEST_F(CameraInputs, ExportedPatchesHaveTheImagesOfTheirStops) {
  const ProgramRun run = rigcal("export session --format patches --out patches --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(parse_json(run.out)["images"], stops);
  const SE3 of_patches = found_from("patches");
  // The turns of the gyro have gone through a trajectory: the map is micrometres apart, and what the few edges of a
  // small image are matched with may be others. A stop's image at another stop would be decimetres off.
  EXPECT_LT((of_patches.t - of_session.t).norm(), 1e-2);
  EXPECT_LT(to_deg(rotation_distance(of_patches.R, of_session.R)), 0.05);
}

TEST_F(CameraInputs, AnLvxFileTakesImagesWithStampsOfItsOwnTime) {
  save_as_lvx(dump(), small_rig_avia(), small_rig_mid40(), (scratch / "run.lvx").string());
  const auto look = parse_json(rigcal("inspect run.lvx --rig session/rig.yaml --json").out);
  ASSERT_EQ(look["stops"].size(), std::size_t{stops});
  const fs::path folder = scratch / "of_lvx/left";
  fs::create_directories(folder);
  const std::vector<FrameRecord> all = frames();
  for (int k = 0; k < stops; ++k) {
    const auto& stop = look["stops"][static_cast<std::size_t>(k)];
    const std::int64_t middle_ns = (stop["start_ns"].get<std::int64_t>() + stop["end_ns"].get<std::int64_t>()) / 2;
    fs::copy_file(image(all[static_cast<std::size_t>(k)]), folder / (std::to_string(middle_ns) + ".png"));
  }
  found_from("run.lvx --rig session/rig.yaml --images of_lvx");
}

TEST_F(CameraInputs, ABagBringsItsImages) {
  BagBytes bag = bag_of_dump(dump(), 0);
  std::uint32_t number = 0;
  for (const FrameRecord& frame : frames()) {
    const auto shot = read_image(image(frame).string());
    ASSERT_TRUE(shot);
    bag.add("/left", image_type, image_md5, frame.stamp_ns,
            image_message(number++, frame.stamp_ns, static_cast<std::uint32_t>(shot->width),
                          static_cast<std::uint32_t>(shot->height), "bayer_rggb8",
                          static_cast<std::uint32_t>(shot->width), shot->bytes));
  }
  save_bytes(scratch / "run.bag", bag.finish());
  found_from("run.bag --rig session/rig.yaml");

  // Those of a folder are taken instead, and the session, which has no times, knows their stops.
  ASSERT_EQ(rigcal("import run.bag --rig session/rig.yaml --images session/images --out of_bag").code, 0);
  const auto imported = read_frames((scratch / "of_bag/images/left/frames.csv").string());
  ASSERT_TRUE(imported) << imported.error().message();
  ASSERT_EQ(imported->size(), std::size_t{stops});
  EXPECT_EQ(imported->back().stop, stops - 1);
  EXPECT_EQ(text_of(scratch / "of_bag/images/left" / imported->back().file), text_of(image(frames().back())));
}

TEST_F(CameraInputs, ImagesOfTheWrongTimesAreMissedInOneSentence) {
  const fs::path folder = scratch / "late/left";
  fs::create_directories(folder);
  for (const FrameRecord& frame : frames())
    fs::copy_file(image(frame), folder / (std::to_string(frame.stamp_ns + 3'600'000'000'000) + ".png"));
  const ProgramRun run =
      rigcal("calibrate session/lidar.pcapng --rig session/rig.yaml --images late --out late_result");
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_THAT(run.out, HasSubstr("8 of 8 images were taken outside of all stops"));
  EXPECT_THAT(run.out, HasSubstr("-3600.000 s"));
  const auto got = load_extrinsics((scratch / "late_result/extrinsics.yaml").string());
  ASSERT_TRUE(got);
  EXPECT_EQ(got->status.at("left"), "failed");
  EXPECT_EQ(got->status.at("mid40"), "good");
}

}  // namespace
}  // namespace rigcal
