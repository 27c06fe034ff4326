#include "drivers/camera/images/image_camera.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>

#include "core/base/seconds.h"
#include "tests/drivers/camera/image_folder_fixture.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::camera {
namespace {

using testing::HasSubstr;
using Kind = Delivery::Kind;
constexpr std::int64_t ms = 1'000'000;

class ImageCamera : public testing::Test {
 protected:
  /// Plays the folder `left` of the scratch folder.
  void play(const CameraConfig& config = {}) {
    camera = ImageBackend({scratch.string(), pace}).make();
    const auto opened = camera->open("left");
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
    auto configured = camera->configure(config);
    ASSERT_TRUE(configured.has_value()) << configured.error().message();
    setup = *std::move(configured);
    ASSERT_TRUE(camera->start().has_value());
  }
  Delivery next(std::int64_t timeout_ns = 2000 * ms) {
    auto delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery.has_value());
    return *std::move(delivery);
  }

  std::filesystem::path scratch = scratch_folder("image_camera");
  ImageCameraOptions::Pace pace = ImageCameraOptions::Pace::as_taken;
  std::unique_ptr<Camera> camera;
  CameraSetup setup;
};

TEST_F(ImageCamera, GivesEachImageOnceAndThenEnds) {
  write_camera_folder(scratch / "left", 5, 1000 * ms);
  play();
  EXPECT_EQ(setup.pixel_format, "Mono8");
  for (int i = 0; i < 5; ++i) {
    const Delivery delivery = next();
    ASSERT_EQ(delivery.kind, Kind::frame);
    const Image image = numbered_image(i);
    EXPECT_TRUE(std::equal(image.bytes.begin(), image.bytes.end(), delivery.frame.pixels().begin()));
    EXPECT_EQ(delivery.frame.facts().frame_id, static_cast<unsigned>(i));
    EXPECT_EQ(delivery.frame.facts().device_stamp_ns, 1'700'000'000'000'000'000 + i * 1000 * ms);
    EXPECT_EQ(delivery.frame.facts().exposure_us, 1500.0);
  }
  EXPECT_EQ(next().kind, Kind::ended);
  EXPECT_EQ(next(0).kind, Kind::nothing);
  EXPECT_EQ(camera->counters().whole(), 5U);
}

TEST_F(ImageCamera, CutsThePartOutOfTheImage) {
  write_camera_folder(scratch / "left", 1, ms);
  CameraConfig config;
  config.region = Region{10, 20, 7, 5};
  config.pixel_format = "BayerRG8";
  play(config);
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().pixel_format, "BayerRG8");
  const Image image = numbered_image(0);
  for (int y = 0; y < 5; ++y) {
    for (int x = 0; x < 7; ++x)
      EXPECT_EQ(delivery.frame.pixels()[static_cast<std::size_t>(7 * y + x)], image.at(10 + x, 20 + y));
  }
}

TEST_F(ImageCamera, KeepsTheRecordedTimesOrTheRateThatIsAsked) {
  write_camera_folder(scratch / "left", 4, 200 * ms);
  pace = ImageCameraOptions::Pace::recorded;
  // A busy machine may make any of them late, the first one, too.
  std::int64_t before_ns = monotonic_now_ns();
  play();
  for (int i = 0; i < 3; ++i) EXPECT_GE(next().frame.facts().host_stamp_ns - before_ns, i * 200 * ms);
  EXPECT_EQ(next(0).kind, Kind::nothing);
  CameraConfig config;
  config.frame_rate = 50.0;
  before_ns = monotonic_now_ns();
  play(config);
  for (int i = 0; i < 4; ++i) EXPECT_GE(next().frame.facts().host_stamp_ns - before_ns, i * 20 * ms);
}

TEST_F(ImageCamera, LosesWhatIsNotTakenInTime) {
  write_camera_folder(scratch / "left", 10, 50 * ms);
  pace = ImageCameraOptions::Pace::recorded;
  CameraConfig config;
  config.buffers = 2;
  play(config);
  const Delivery first = next();
  const Delivery second = next();
  EXPECT_EQ(next(1000 * ms).kind, Kind::ended);
  EXPECT_EQ(first.frame.facts().frame_id, 0U);
  EXPECT_EQ(second.frame.facts().frame_id, 1U);
  EXPECT_EQ(camera->counters().no_buffer, 8U);
}

TEST_F(ImageCamera, DamagedAndForeignImagesAreFlaggedAndHaveNoPixels) {
  const auto folder = scratch / "left";
  write_camera_folder(folder, 5, ms);
  std::filesystem::resize_file(folder / "1.png", 60);
  ASSERT_TRUE(write_image((folder / "2.png").string(), numbered_image(2, 32, 48)).has_value());
  std::filesystem::remove(folder / "3.png");
  play();
  using enum FrameStatus;
  for (const FrameStatus expected : {whole, device_error, wrong_size, device_error, whole}) {
    const Delivery delivery = next();
    ASSERT_EQ(delivery.kind, Kind::frame);
    EXPECT_EQ(delivery.frame.facts().status, expected);
    EXPECT_EQ(delivery.frame.pixels().empty(), expected != whole);
    EXPECT_EQ(delivery.frame.is_whole(), expected == whole);
  }
  EXPECT_EQ(camera->counters().damaged(), 3U);
}

TEST_F(ImageCamera, TakesFilesNamedByNumbers) {
  std::filesystem::create_directories(scratch / "left");
  for (const int number : {30, 4, 200}) {
    const std::string name = std::to_string(number) + ".png";
    ASSERT_TRUE(write_image((scratch / "left" / name).string(), numbered_image(number)).has_value());
  }
  pace = ImageCameraOptions::Pace::recorded;
  play();
  EXPECT_FALSE(setup.has_device_stamps);
  for (const int number : {4, 30, 200}) {
    const Delivery delivery = next();
    EXPECT_EQ(delivery.frame.pixels()[0], static_cast<std::uint8_t>(5 * number));
    EXPECT_FALSE(delivery.frame.facts().device_stamp_ns.has_value());
  }
}

TEST_F(ImageCamera, SaysWhatAFolderDoesNot) {
  write_camera_folder(scratch / "left", 1, ms);
  CameraConfig config;
  config.exposure_us = 5000.0;
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  play(config);
  ASSERT_EQ(setup.notes.size(), 2U);
  EXPECT_THAT(setup.notes[0], HasSubstr("exposure"));
  EXPECT_THAT(setup.notes[1], HasSubstr("line"));
}

TEST_F(ImageCamera, AFolderWithoutImagesIsAnError) {
  std::filesystem::create_directories(scratch / "left");
  camera = ImageBackend({scratch.string(), pace}).make();
  EXPECT_FALSE(camera->open("left").has_value());
  EXPECT_THAT(camera->open((scratch / "left").string()).error().message(), HasSubstr("no images"));
  std::ofstream(scratch / "left" / "7.png") << "no image";
  EXPECT_THAT(camera->open("left").error().message(), HasSubstr("7.png"));
  EXPECT_FALSE(ImageBackend({"/no/such/folder", pace}).enumerate().has_value());
}

}  // namespace
}  // namespace rigcal::camera
