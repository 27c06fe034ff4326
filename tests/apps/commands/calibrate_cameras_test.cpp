// Cameras as a user of `rigcal calibrate` meets them, on one simulated run with two small ones.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "core/base/text.h"
#include "core/io/extrinsics_file.h"
#include "core/io/frame_files.h"
#include "core/io/image_file.h"
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

constexpr const char* rig_yaml = R"(rigcal: 1
name: test
base: avia
sensors:
  left:
    type: camera
    driver: aravis
    pixel_format: BayerRG8
    exposure_us: 5000
    intrinsics: {model: radtan, width: 640, height: 512, fx: 431.5, fy: 431.5, cx: 319.5, cy: 255.5,
                 distortion: [-0.1, 0.09, 3.0e-4, -2.0e-4, 0.0]}
  avia: {type: livox_avia, broadcast_code: "3JEDHC900100791", ip: 192.168.1.179}
  mid40: {type: livox_mid40, broadcast_code: "0TFDG3B00600551", ip: 192.168.1.21}
  right:
    type: camera
    driver: aravis
    pixel_format: Mono12
    exposure_us: 5000
    intrinsics: {model: radtan, width: 640, height: 512, fx: 431.5, fy: 431.5, cx: 319.5, cy: 255.5,
                 distortion: [-0.1, 0.09, 3.0e-4, -2.0e-4, 0.0]}
initial_extrinsics:
  mid40: {translation: [-0.15, 0.0, -0.15], rotation_xyzw: [0.0, 0.0, -0.965926, 0.258819]}
  left: {translation: [0.05, 0.06, -0.05], rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}
  right: {translation: [0.05, -0.06, -0.05], rotation_xyzw: [-0.5, 0.5, -0.5, 0.5]}
turntable: {driver: manual, axis: [0, 0, 1]}
)";

class CalibrateCameras : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    scratch = scratch_folder("calibrate_cameras");
    std::ofstream(scratch / "rig.yaml") << rig_yaml;
    const ProgramRun made = rigcal(
        "simulate courtyard --rig rig.yaml --out session --patches --stops 8 --points 60000 --mount-error 20mm,1deg");
    ASSERT_EQ(made.code, 0) << made.err;
    first = rigcal("calibrate session --out first --json --threads 2");
  }

  static ProgramRun rigcal(const std::string& arguments) { return run_rigcal(arguments, scratch); }
  static std::string file(const std::string& name) { return text_of(scratch / name); }
  static ExtrinsicsFile extrinsics(const std::string& result) {
    const auto loaded = load_extrinsics((scratch / result / "extrinsics.yaml").string());
    EXPECT_TRUE(loaded) << loaded.error().message();
    return loaded ? *loaded : ExtrinsicsFile{};
  }
  // The LiDARs' patches alone; images are the test's to give.
  static void session_without_images(const std::string& name) {
    fs::create_directories(scratch / name / "patches");
    for (const char* sensor : {"avia", "mid40"}) {
      fs::create_directory_symlink(scratch / "session/patches" / sensor, scratch / name / "patches" / sensor);
    }
    fs::copy_file(scratch / "session/rig.yaml", scratch / name / "rig.yaml");
    fs::copy_file(scratch / "session/session.json", scratch / name / "session.json");
  }
  static fs::path image(const std::string& camera, int stop) {
    return scratch / "session/patches/image" / camera / (std::to_string(stop) + ".png");
  }
  // Without the intrinsics of `left`, and without a guess of `right`.
  static void write_poor_rig() {
    std::string rig = file("session/rig.yaml");
    const std::size_t intrinsics = rig.find("    intrinsics:");
    rig.erase(intrinsics, rig.find("  \"avia\"", intrinsics) - intrinsics);
    const std::size_t guess = rig.rfind("  \"right\":");
    rig.erase(guess, rig.find("turntable:") - guess);
    std::ofstream(scratch / "poor.yaml") << rig;
  }
  static void expect_lidars_as_ever(const std::string& result) {
    const ExtrinsicsFile got = extrinsics(result);
    EXPECT_EQ(got.status.at("mid40"), "good");
    EXPECT_EQ(got.T_base_sensor.at("mid40").matrix(), extrinsics("first").T_base_sensor.at("mid40").matrix());
  }

  static inline fs::path scratch;
  static inline ProgramRun first;
};

TEST_F(CalibrateCameras, AreFoundWithTheLidars) {
  const ExtrinsicsFile got = extrinsics("first");
  EXPECT_EQ(got.names, (std::vector<std::string>{"left", "avia", "mid40", "right"}));
  const auto truth = load_extrinsics((scratch / "session/ground_truth.yaml").string());
  ASSERT_TRUE(truth);
  for (const char* camera : {"left", "right"}) {
    ASSERT_NE(got.status.at(camera), "failed") << first.out;
    const SE3& T = got.T_base_sensor.at(camera);
    // A pixel is 2.3 mrad here, 2 cm in 10 m: what matters is that no false optimum was taken.
    EXPECT_LT((T.t - truth->T_base_sensor.at(camera).t).norm(), 0.06) << camera;
    EXPECT_LT(to_deg(rotation_distance(T.R, truth->T_base_sensor.at(camera).R)), 0.4) << camera;
  }
  const nlohmann::json report = parse_json(first.out);
  EXPECT_TRUE(fits_schema("calibrate.json", report));
  EXPECT_TRUE(fits_schema("report.json", parse_json(file("first/report.json"))));
  ASSERT_EQ(report["cameras"].size(), 2U);
  EXPECT_EQ(report["cameras"][0]["name"], "left");
  EXPECT_EQ(report["cameras"][0]["images"].size(), 8U);
  EXPECT_THAT(rigcal("evaluate first --truth session/ground_truth.yaml").out, HasSubstr("right"));
}

TEST_F(CalibrateCameras, AreCountedByInspect) {
  EXPECT_THAT(rigcal("inspect session").out, HasSubstr("images of right: 8"));
}

TEST_F(CalibrateCameras, ColourTheMap) {
  const std::string ply = file("first/map.ply");
  const std::size_t header = ply.find("end_header\n");
  ASSERT_NE(header, std::string::npos);
  constexpr std::size_t vertex = 17;  // x y z red green blue intensity sensor
  std::size_t coloured = 0;
  std::size_t points = 0;
  for (std::size_t at = header + 11; at + vertex <= ply.size(); at += vertex, ++points) {
    coloured += ply[at + 12] != ply[at + 13] || ply[at + 13] != ply[at + 14] ? 1 : 0;
  }
  EXPECT_GT(coloured, points / 50);
}

TEST_F(CalibrateCameras, GiveTheSameBitsWithOneThread) {
  EXPECT_EQ(rigcal("calibrate session --out single --threads 1").code, first.code);
  EXPECT_TRUE(file("single/extrinsics.yaml") == file("first/extrinsics.yaml"));
  EXPECT_TRUE(file("single/map.ply") == file("first/map.ply"));
}

TEST_F(CalibrateCameras, AreLeftOutWithoutAWordWhereOnlyLidarsAreAskedFor) {
  const ProgramRun run = rigcal("calibrate session --out lidars --stages joint");
  EXPECT_EQ(run.code, 0) << run.out << run.err;
  EXPECT_THAT(run.out + run.err, Not(HasSubstr("left")));
  EXPECT_THAT(extrinsics("lidars").names, testing::ElementsAre("avia", "mid40"));
  expect_lidars_as_ever("lidars");
}

TEST_F(CalibrateCameras, OfBadImagesTellOnceEachAndLeaveTheLidarsAlone) {
  session_without_images("bad");
  const fs::path left = scratch / "bad/patches/image/left";
  fs::create_directories(left);
  for (const int stop : {0, 1, 2, 3, 4}) fs::copy_file(image("left", stop), left / image("left", stop).filename());
  const auto shot = read_image(image("left", 5).string());
  ASSERT_TRUE(shot);
  Image black = *shot;
  std::fill(black.bytes.begin(), black.bytes.end(), std::uint8_t{0});
  ASSERT_TRUE(write_image((left / "5.png").string(), black));
  Image small = *shot;
  small.height = 100;
  small.bytes.resize(small.row_bytes() * 100);
  ASSERT_TRUE(write_image((left / "6.png").string(), small));
  std::ofstream(left / "7.png") << file("session/patches/image/left/7.png").substr(0, 5000);
  fs::copy_file(image("left", 0), left / "99.png");
  const ProgramRun run = rigcal("calibrate bad --out bad_result");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("5.png: the image of left is black"));
  EXPECT_THAT(run.err,
              HasSubstr("6.png: the image is 640 x 100 pixels large, the intrinsics of left are for 640 x 512"));
  EXPECT_THAT(run.err, HasSubstr("7.png: the image is damaged or cut short"));
  EXPECT_THAT(run.err, HasSubstr("left: 1 of 9 images were taken outside of all stops"));
  EXPECT_THAT(run.out, HasSubstr("- the recording has no images of it; give them by --images DIR"));
  EXPECT_EQ(extrinsics("bad_result").status.at("right"), "failed");
  expect_lidars_as_ever("bad_result");
  const nlohmann::json report = parse_json(file("bad_result/report.json"));
  ASSERT_EQ(report["cameras"].size(), 1U);
  EXPECT_EQ(report["cameras"][0]["images"].size(), 5U);
}

TEST_F(CalibrateCameras, TakeImagesFromElsewhereByFramesAndOneImageIsWeak) {
  session_without_images("plain");
  const fs::path images = scratch / "elsewhere";
  fs::create_directories(images / "left");
  fs::create_directories(images / "right");
  fs::copy_file(image("left", 3), images / "left/000000.png");
  ASSERT_TRUE(
      write_frames((images / "left/frames.csv").string(), std::vector<FrameRecord>{{"000000.png", 17, {}, {}, {}, 3}}));
  std::ofstream(images / "right/frames.csv") << "file,stamp_ns,trigger,exposure_us,device_stamp,stop\nx.png,-4,,,,\n";
  const ProgramRun run = rigcal("calibrate plain --images elsewhere --out elsewhere_result");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.out, HasSubstr("frames.csv:2: stamp_ns is '-4'"));
  // Whether one image is enough depends on what it shows; that it is all that there is must be said in any case.
  EXPECT_NE(extrinsics("elsewhere_result").status.at("left"), "good");
  EXPECT_THAT(extrinsics("elsewhere_result").reasons.at("left"), Not(IsEmpty()));
  expect_lidars_as_ever("elsewhere_result");
  EXPECT_EQ(rigcal("calibrate plain --images nowhere --out nowhere_result").code, 3);
}

TEST_F(CalibrateCameras, NeedIntrinsicsButNoGuess) {
  write_poor_rig();
  const ProgramRun run = rigcal("calibrate session --rig poor.yaml --out poor_result");
  EXPECT_EQ(run.code, 1) << run.err;
  EXPECT_THAT(run.out, HasSubstr("the rig file has no intrinsics for it"));
  // Few small images of a short run do not make it good, but they find it.
  const ExtrinsicsFile poor = extrinsics("poor_result");
  const auto truth = load_extrinsics((scratch / "session/ground_truth.yaml").string());
  ASSERT_TRUE(truth && poor.T_base_sensor.count("right") == 1) << run.out;
  const SE3 off = truth->T_base_sensor.at("right").inverse() * poor.T_base_sensor.at("right");
  EXPECT_LT(off.t.norm(), 0.1);
  EXPECT_LT(to_deg(rotation_distance(off.R, Matrix3d::Identity())), 1.0);
  expect_lidars_as_ever("poor_result");
}

TEST_F(CalibrateCameras, TakeAGuessFromElsewhereAndGiveTheirIntrinsicsWhereTheyAreToBeFound) {
  write_poor_rig();
  std::string rough = file("session/ground_truth.yaml");
  rough.insert(rough.find("sensors:\n") + 9,
               "  rihgt: {translation: [0.0, 0.0, 0.0], rotation_xyzw: [0.0, 0.0, 0.0, 1.0]}\n");
  std::ofstream(scratch / "rough.yaml") << rough;
  const ProgramRun helped =
      rigcal("calibrate session --rig poor.yaml --initial rough.yaml --refine-intrinsics --out helped");
  EXPECT_THAT(helped.out, Not(HasSubstr("without a rough pose")));
  EXPECT_THAT(helped.err, HasSubstr("rough.yaml: rihgt is no sensor of the rig: its extrinsics are not used"));
  EXPECT_THAT(file("helped/report.json"), HasSubstr("right/0.png"));
  const ExtrinsicsFile got = extrinsics("helped");
  ASSERT_EQ(got.intrinsics.count("right"), 1U);
  EXPECT_NEAR(got.intrinsics.at("right").fx, 431.5, 4.0);
  EXPECT_TRUE(extrinsics("first").intrinsics.empty());
  const ProgramRun run = rigcal("export helped --rig session/rig.yaml --format opencv --out helped.yml");
  EXPECT_LE(run.code, 1) << run.err;
  EXPECT_THAT(file("helped.yml"), HasSubstr("[" + number_text(got.intrinsics.at("right").fx) + ", 0.0, 319.5"));
}

// Half a turn from its guess nothing is found; without that guess it is.
TEST_F(CalibrateCameras, AreFoundUpsideDownByTheirImagesAlone) {
  session_without_images("turned");
  fs::create_directories(scratch / "turned/patches/image/left");
  for (int stop = 0; stop < 8; ++stop) {
    auto shot = read_image(image("left", stop).string());
    ASSERT_TRUE(shot);
    std::reverse(shot->bytes.begin(), shot->bytes.end());
    ASSERT_TRUE(write_image((scratch / "turned/patches/image/left" / image("left", stop).filename()).string(), *shot));
  }
  const ProgramRun run = rigcal("calibrate turned --out turned_result --require 50mm,0.4deg");
  EXPECT_EQ(run.code, 1);
  const ExtrinsicsFile got = extrinsics("turned_result");
  EXPECT_EQ(got.status.at("left"), "weak") << run.out;
  EXPECT_THAT(run.out, HasSubstr("its images alone lead to this pose"));
  const auto truth = load_extrinsics((scratch / "session/ground_truth.yaml").string());
  ASSERT_TRUE(truth && got.T_base_sensor.count("left") == 1);
  const SE3 off = truth->T_base_sensor.at("left").inverse() * got.T_base_sensor.at("left");
  EXPECT_LT(off.t.norm(), 0.1);
  EXPECT_NEAR(to_deg(log_so3(off.R).norm()), 180.0, 1.0);
}

TEST_F(CalibrateCameras, AreToldThatTheirImagesAreCountedAStopLate) {
  session_without_images("late");
  fs::create_directories(scratch / "late/patches/image/left");
  for (int stop = 0; stop < 7; ++stop)
    fs::copy_file(image("left", stop), scratch / "late/patches/image/left" / image("left", stop + 1).filename());
  const ProgramRun run = rigcal("calibrate late --out late_result --require 50mm,0.4deg");
  EXPECT_EQ(run.code, 1);
  EXPECT_EQ(extrinsics("late_result").status.at("left"), "failed") << run.out;
  EXPECT_THAT(run.out, HasSubstr("fit well where each is taken as of the stop before its own"));
}

}  // namespace
}  // namespace rigcal
