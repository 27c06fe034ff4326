#include "core/pipeline/camera_stage.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/pipeline/rig_calibration.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/light_recording.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/pinhole.h"

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Stripes, whose values the camera's depth does not hide.
Image stripes(int bits, int largest) {
  Image image{32, 24, 1, bits, {}, {}};
  for (int i = 0; i < 32 * 24; ++i) {
    const int value = i % 8 < 4 ? 0 : largest;
    image.bytes.push_back(static_cast<std::uint8_t>(value & 0xFF));
    if (bits == 16) image.bytes.push_back(static_cast<std::uint8_t>(value >> 8));
  }
  return image;
}

TEST(CameraViews, LeaveOutWhatShowsNothingByName) {
  NotingReporter reporter;
  const std::vector<StillImage> images{{0, "a.png", stripes(8, 200)}, {1, "b.png", stripes(8, 3)}};
  const std::vector<CameraView> views = camera_views(images, 0, "left", {reporter});
  ASSERT_EQ(views.size(), 1U);
  EXPECT_EQ(views[0].file, "a.png");
  EXPECT_THAT(reporter.warnings, ElementsAre(HasSubstr("b.png: the image of left is black")));
}

// At the first stop the lamps were off.
std::vector<StillImage> dark_and_bright() { return {{0, "a.png", stripes(16, 500)}, {1, "b.png", stripes(16, 4000)}}; }

TEST(CameraViews, OfOneCameraAreOnOneScale) {
  NotingReporter reporter;
  const std::vector<StillImage> images = dark_and_bright();
  const std::vector<CameraView> views = camera_views(images, 0, "left", {reporter});
  ASSERT_EQ(views.size(), 2U);
  EXPECT_NEAR(views[0].grey.at(4, 0), 500.0 / 4095.0 * 255.0, 0.01);
  EXPECT_NEAR(views[1].grey.at(4, 0), 4000.0 / 4095.0 * 255.0, 0.01);
}

TEST(ColourPictures, OfOneCameraAreOnTheScaleOfItsViews) {
  std::vector<StillImage> images = dark_and_bright();
  images.push_back({2, "c.png", stripes(8, 200)});
  const std::vector<ColourPicture> pictures = colour_pictures(images);
  ASSERT_EQ(pictures.size(), 3U);
  EXPECT_EQ(pictures[0].rgb.at(4, 0, 0), 31) << "500 of 4095";
  EXPECT_EQ(pictures[1].rgb.at(4, 0, 0), 249);
  EXPECT_EQ(pictures[2].rgb.at(4, 0, 0), 200) << "8 bits have their own";
}

Sensor camera(const std::string& name) {
  Sensor sensor;
  sensor.name = name;
  sensor.camera.emplace();
  sensor.camera->intrinsics = pinhole(32, 24, 20.0);
  return sensor;
}

TEST(CalibrateRig, SaysOfEveryCameraWhyItIsNotFoundAndKeepsTheLidars) {
  sim::LightRigOptions light;
  light.turntable.stops = 6;
  light.shots_per_patch = 15000;
  LightRecording run = make_light_recording(*sim::make_light_rig(*sim::load_scene("room"), light));
  // Cameras before, between and behind the LiDARs of the rig file; sensors are numbered anew.
  Rig rig = run.rig;
  rig.sensors.insert(rig.sensors.begin(), camera("unknown_lens"));
  rig.sensors.insert(rig.sensors.begin() + 2, camera("nowhere"));
  rig.sensors.push_back(camera("no_images"));
  rig.sensors.push_back(camera("dark"));
  rig.sensors.push_back(camera("twin"));
  rig.sensors[0].camera->intrinsics.reset();
  rig.base = rig.find(run.rig.base_sensor().name);
  run.recording.lidar_sensors.clear();
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    if (rig.sensors[k].is_lidar()) run.recording.lidar_sensors.push_back(static_cast<int>(k));
  }
  std::vector<std::string> asked;
  std::vector<CameraRecording> cameras;
  for (const Sensor& sensor : rig.sensors) {
    if (sensor.is_lidar()) continue;
    CameraRecording one{rig.find(sensor.name), SE3{}, {}};
    if (sensor.name == "nowhere" || sensor.name == "twin") one.guess_T_base_camera.reset();
    if (sensor.name == "dark") one.guess_T_base_camera->t = {150.0, 0.0, -80.0};
    one.read_images = [name = sensor.name, &asked](const RunContext&) {
      asked.push_back(name);
      StillImages still;
      if (name == "dark") still.images.push_back({0, "dark.png", stripes(8, 1)});
      if (name == "no_images") still.why_none = "it has none";
      if (name == "nowhere" || name == "twin") still.images.push_back({0, "same.png", stripes(16, 4000)});
      return still;
    };
    cameras.push_back(one);
  }
  NotingReporter reporter;
  const auto lidars =
      calibrate_lidars(run.rig, make_light_recording(*sim::make_light_rig(*sim::load_scene("room"), light)).recording,
                       run.guess, {}, {reporter});
  const auto result = calibrate_rig(rig, run.recording, cameras, run.guess, {}, {reporter});
  ASSERT_TRUE(result && lidars);
  ASSERT_EQ(result->sensors.size(), rig.sensors.size());
  std::map<std::string, SensorResult> by_name;
  for (std::size_t k = 0; k < rig.sensors.size(); ++k) {
    EXPECT_EQ(result->sensors[k].name, rig.sensors[k].name);
    by_name[result->sensors[k].name] = result->sensors[k];
  }
  EXPECT_EQ(result->status, Status::failed);
  EXPECT_THAT(by_name["unknown_lens"].reasons, ElementsAre(HasSubstr("no intrinsics")));
  EXPECT_THAT(by_name["nowhere"].reasons, ElementsAre(HasSubstr("its images are those of twin, too"),
                                                      HasSubstr("none of its images shows an edge")));
  EXPECT_THAT(by_name["twin"].reasons, testing::Contains(HasSubstr("its images are those of nowhere, too")));
  EXPECT_THAT(by_name["no_images"].reasons, ElementsAre("it has none"));
  EXPECT_THAT(by_name["dark"].reasons, ElementsAre(HasSubstr("none of its images shows anything")));
  EXPECT_EQ(std::count(reporter.warnings.begin(), reporter.warnings.end(),
                       "the rough pose of dark is 170.0 m from " + rig.base_sensor().name +
                           ": initial_extrinsics are in metres; were these millimetres?"),
            1);
  EXPECT_THAT(reporter.warnings, testing::Not(testing::Contains(HasSubstr("the rough pose of no_images"))));
  EXPECT_THAT(asked, ElementsAre("nowhere", "no_images", "dark", "twin")) << "only where they are of use";
  for (const SensorResult& lidar : lidars->sensors) {
    EXPECT_EQ(by_name[lidar.name].status, lidar.status);
    EXPECT_EQ(by_name[lidar.name].T_base_sensor->matrix(), lidar.T_base_sensor->matrix());
  }
  // Points of the map still name who saw them.
  ASSERT_EQ(result->map.size(), lidars->map.size());
  for (std::size_t i = 0; i < result->map.size(); i += 997) {
    EXPECT_EQ(result->sensors[result->map[i].sensor].name, lidars->sensors[lidars->map[i].sensor].name);
  }
  EXPECT_THAT(result->map_rgb, IsEmpty());

  RigCalibrationOptions lidars_only;
  lidars_only.cameras.reset();
  const auto without = calibrate_rig(rig, run.recording, cameras, run.guess, lidars_only, {reporter});
  ASSERT_TRUE(without);
  EXPECT_EQ(without->sensors.size(), lidars->sensors.size());
  EXPECT_EQ(without->status, lidars->status);
}

}  // namespace
}  // namespace rigcal
