#include "simdata/session/session_images.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "core/io/frame_files.h"
#include "core/io/image_file.h"
#include "simdata/camera/exposure_plan.h"
#include "simdata/scene/scene_file.h"
#include "simdata/session/session_writer.h"
#include "tests/support/files.h"
#include "tests/support/pinhole.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::sim {
namespace {

namespace fs = std::filesystem;

// The nominal rig with two small cameras: one triggered, 0.5 ms late, one that runs freely.
Rig rig_with_cameras() {
  Rig rig = nominal_rig();
  Sensor camera;
  camera.name = "left";
  camera.camera.emplace();
  camera.camera->pixel_format = "BayerRG8";
  camera.camera->exposure_us = 4000.0;
  camera.camera->trigger = TriggerSettings{"Line0", "rising", 500.0};
  camera.camera->intrinsics = pinhole(64, 48, 43.0);
  Matrix3d R;
  R << 0, 0, 1, -1, 0, 0, 0, -1, 0;
  camera.initial_T_base_sensor = SE3{R, Vector3d(0.05, 0.06, -0.05)};
  rig.sensors.push_back(camera);
  camera.name = "right";
  camera.camera->pixel_format = "Mono12";
  camera.camera->trigger.reset();
  rig.sensors.push_back(camera);
  camera.name = "unknown";
  camera.camera->intrinsics.reset();
  rig.sensors.push_back(camera);
  return rig;
}

RunOptions short_run() {
  RunOptions options;
  options.turntable.stops = 2;
  options.turntable.dwell_s = 0.2;
  options.turntable.initial_still_s = 0.0;
  options.turntable.final_still_s = 0.0;
  options.turntable.turn_s = 0.3;
  options.images_per_stop = 3;
  return options;
}

TEST(SessionImages, StampsAgreeWithPulsesAndStops) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  const std::string path = fresh_path("stamps");
  const auto summary = simulate_session(*scene, rig_with_cameras(), short_run(), path, {silent});
  ASSERT_TRUE(summary.has_value()) << summary.error().message();
  EXPECT_EQ(12U, summary->images);
  const auto truth = load_ground_truth(path + "/ground_truth.yaml");
  const auto pulses = read_trigger(path + "/trigger.csv");
  ASSERT_TRUE(truth && pulses);
  ASSERT_EQ(6U, pulses->size());
  for (const char* name : {"left", "right"}) {
    const auto frames = read_frames(path + "/images/" + name + "/frames.csv");
    ASSERT_TRUE(frames.has_value()) << frames.error().message();
    ASSERT_EQ(6U, frames->size());
    for (std::size_t i = 0; i < 6; ++i) {
      const FrameRecord& frame = (*frames)[i];
      const Stop& stop = truth->stops[static_cast<std::size_t>(*frame.stop)].stop;
      EXPECT_EQ(i / 3, static_cast<std::size_t>(*frame.stop));
      // The whole exposure lies within the stop.
      EXPECT_GT(frame.stamp_ns - 2'000'000, stop.start_ns);
      EXPECT_LT(frame.stamp_ns + 2'000'000, stop.end_ns);
      EXPECT_EQ(4000.0, frame.exposure_us);
      const bool triggered = std::string(name) == "left";
      EXPECT_EQ(triggered, frame.trigger.has_value());
      const std::int64_t after = triggered ? 2'500'000 : 2'000'000;  // delay and half of the exposure
      EXPECT_NEAR(static_cast<double>(frame.stamp_ns - (*pulses)[i].stamp_ns), static_cast<double>(after), 1.0);
      // The camera's clock: from its truth, at the beginning of the exposure.
      const ClockTruth clock = truth->clocks.at(name);
      const double since_ns = static_cast<double>(frame.stamp_ns - 2'000'000 - RunOptions{}.start_ns);
      EXPECT_NEAR(
          static_cast<double>(*frame.device_stamp),
          static_cast<double>(clock.offset_ns + RunOptions{}.start_ns) + since_ns * (1.0 + clock.drift_ppm * 1e-6),
          2e3);
      const auto image = read_image(path + "/images/" + name + "/" + frame.file);
      ASSERT_TRUE(image.has_value()) << image.error().message();
      EXPECT_EQ(64, image->width);
      EXPECT_EQ(triggered ? 8 : 16, image->bits);
    }
  }
  EXPECT_FALSE(fs::exists(path + "/images/unknown"));
  // Mounted off the rig file as the LiDARs are.
  const Rig rig = rig_with_cameras();
  for (std::size_t i = 4; i < 6; ++i) {
    const SE3& nominal = *rig.sensors[i].initial_T_base_sensor;
    const SE3& real = truth->T_base_sensor[i].second;
    EXPECT_NEAR(0.2, (real.t - nominal.t).norm(), 1e-9);
    EXPECT_NEAR(10.0, to_deg(log_so3(nominal.R.transpose() * real.R).norm()), 1e-6);
  }
}

TEST(SessionImages, ACameraThatExposesAtTheEndOfAPulseIsLaterByItsLength) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  const std::string path = fresh_path("falling");
  Rig rig = rig_with_cameras();
  rig.sensors[static_cast<std::size_t>(rig.find("left"))].camera->trigger->activation = "falling";
  rig.trigger.emplace().pulse_us = 3000.0;
  ASSERT_TRUE(simulate_session(*scene, rig, short_run(), path, {silent}).has_value());
  const auto pulses = read_trigger(path + "/trigger.csv");
  const auto frames = read_frames(path + "/images/left/frames.csv");
  ASSERT_TRUE(pulses && frames);
  ASSERT_EQ(frames->size(), pulses->size());
  for (std::size_t i = 0; i < frames->size(); ++i)
    EXPECT_NEAR(static_cast<double>((*frames)[i].stamp_ns - (*pulses)[i].stamp_ns), 5'500'000.0, 1.0);
}

TEST(SessionImages, TheSameSeedGivesTheSameImagesAndCamerasDoNotTouchThePackets) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  RunOptions options = short_run();
  options.images_per_stop = 1;
  const std::string a = fresh_path("a");
  const std::string b = fresh_path("b");
  const std::string c = fresh_path("c");
  ASSERT_TRUE(simulate_session(*scene, rig_with_cameras(), options, a, {silent}).has_value());
  ASSERT_TRUE(simulate_session(*scene, rig_with_cameras(), options, b, {silent}).has_value());
  options.images_per_stop = 0;
  ASSERT_TRUE(simulate_session(*scene, rig_with_cameras(), options, c, {silent}).has_value());
  for (const char* file :
       {"images/left/000000.png", "images/right/000001.png", "images/left/frames.csv", "trigger.csv"})
    EXPECT_TRUE(!text_of(fs::path(a) / file).empty() && text_of(fs::path(a) / file) == text_of(fs::path(b) / file));
  EXPECT_TRUE(text_of(fs::path(a) / "lidar.pcapng") == text_of(fs::path(c) / "lidar.pcapng"));
  EXPECT_FALSE(fs::exists(fs::path(c) / "images"));
  EXPECT_FALSE(fs::exists(fs::path(c) / "trigger.csv"));
}

TEST(SessionImages, APatchFolderHasOneImageOfEachCameraAndStop) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  LightRigOptions options;
  options.turntable.stops = 3;
  options.shots_per_patch = 50;
  options.with_images = true;
  const Rig rig = rig_with_cameras();
  const std::string path = fresh_path("patches");
  const auto summary = simulate_patches(*scene, rig, options, path, {silent});
  ASSERT_TRUE(summary.has_value()) << summary.error().message();
  EXPECT_EQ(6U, summary->images);
  for (const char* file : {"left/0.png", "left/2.png", "right/1.png"})
    EXPECT_TRUE(read_image(path + "/patches/image/" + file).has_value()) << file;
  const auto folder = list_patch_folder(path + "/patches", rig);
  ASSERT_TRUE(folder.has_value());
  EXPECT_TRUE(folder->unknown.empty());
}

TEST(SessionImages, ARigWhoseCameraIsNotKnownLeavesNothingBehind) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  Rig rig = rig_with_cameras();
  rig.sensors[4].camera->pixel_format = "Coord3D_ABC32f";
  const std::string path = fresh_path("refused");
  const auto refused = simulate_session(*scene, rig, short_run(), path, {silent});
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), testing::HasSubstr("'left'"));
  EXPECT_FALSE(fs::exists(path));
}

TEST(ExposurePlan, WaitsUntilTheRigHasSettledAndEndsWithinTheStop) {
  const std::vector<Rest> rests{{0, 0.0, 3.0}, {1, 4.5, 6.5}, {1, 6.6, 6.606}, {2, 8.0, 8.5}};
  const auto pulses = plan_exposures(rests, 2, 0.01);
  ASSERT_EQ(6U, pulses.size());
  EXPECT_EQ(0, pulses[0].stop);
  EXPECT_EQ(3, pulses[4].stop);  // the third rest is shorter than an exposure
  for (const ExposurePulse& pulse : pulses) {
    const Rest& rest = rests[static_cast<std::size_t>(pulse.stop)];
    EXPECT_GE(pulse.time_s, rest.start_s + std::min(0.6, 0.4 * (rest.end_s - rest.start_s)));
    EXPECT_LE(pulse.time_s + 0.01, rest.end_s);
  }
}

}  // namespace
}  // namespace rigcal::sim
