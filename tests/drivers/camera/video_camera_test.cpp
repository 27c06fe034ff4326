// Cameras of Video4Linux with the kernel's end answered by the test.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <cerrno>

#include "drivers/camera/v4l2/video_backend.h"
#include "drivers/camera/v4l2/video_formats.h"
#include "tests/drivers/camera/fake_video_kernel.h"

namespace rigcal::camera {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;
using Kind = Delivery::Kind;

constexpr std::int64_t ms = 1'000'000;
constexpr std::int64_t patience = 2000 * ms;

class VideoCamera : public testing::Test {
 protected:
  void open() {
    const auto opened = camera->open(kernel->path);
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
  }
  CameraSetup configure(const CameraConfig& config) {
    auto configured = camera->configure(config);
    EXPECT_TRUE(configured.has_value()) << configured.error().message();
    return configured ? *configured : CameraSetup{};
  }
  void stream(const CameraConfig& config = {}) {
    open();
    setup = configure(config);
    const auto started = camera->start();
    ASSERT_TRUE(started.has_value()) << started.error().message();
  }
  Delivery next(std::int64_t timeout_ns = patience) {
    auto delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery.has_value());
    return delivery ? *std::move(delivery) : Delivery{};
  }
  std::string error_of(const CameraConfig& config) {
    const auto configured = camera->configure(config);
    EXPECT_FALSE(configured.has_value());
    return configured ? "" : configured.error().message();
  }
  std::int32_t control(std::uint32_t id) { return kernel->controls.at(id).value; }

  std::shared_ptr<FakeVideoKernel> kernel = std::make_shared<FakeVideoKernel>();
  std::unique_ptr<Camera> camera = VideoBackend(kernel).make();
  CameraSetup setup;
};

TEST_F(VideoCamera, SetsUpWhatIsAskedAndPutsItBack) {
  open();
  CameraConfig config;
  config.pixel_format = "BayerRG12";
  config.region = Region{10, 20, 100, 50};
  config.exposure_us = 2500.0;
  config.gain = 55.0;
  config.frame_rate = 25.0;
  setup = configure(config);
  EXPECT_EQ(setup.pixel_format, "BayerRG12");
  EXPECT_EQ(setup.image_bytes, 100U * 50 * 2);
  EXPECT_EQ(setup.frame_rate, 25.0);
  EXPECT_EQ(setup.exposure_us, 2500.0);
  EXPECT_EQ(setup.host_stamp, HostStamp::arrival_end);
  EXPECT_EQ(setup.frame_ids.bits, 32);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_ABSOLUTE), 25);
  EXPECT_EQ(control(V4L2_CID_AUTOGAIN), 0);
  EXPECT_EQ(control(V4L2_CID_GAIN), 55);
  camera->close();
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_ABSOLUTE), 150);
  EXPECT_EQ(control(V4L2_CID_AUTOGAIN), 1);
  EXPECT_EQ(control(V4L2_CID_GAIN), 20);
  open();
  setup = configure({});
  EXPECT_EQ(setup.pixel_format, "Mono8");
  EXPECT_EQ(setup.width, 320);
  EXPECT_EQ(setup.frame_rate, 50.0);
}

TEST_F(VideoCamera, OfWhichMomentItsStampsAreIsWhatTheDriverDoes) {
  const auto stamp_with = [&](const std::string& driver, std::uint32_t flags) {
    kernel->driver = driver;
    kernel->stamp_flags = flags;
    open();
    const HostStamp stamp = configure({}).host_stamp;
    camera->close();
    return stamp;
  };
  constexpr std::uint32_t exposure = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
  EXPECT_EQ(stamp_with("vivid", exposure), HostStamp::exposure_start);
  // Stamps of another clock are not used, but the time at which the frame was taken.
  EXPECT_EQ(stamp_with("vivid", V4L2_BUF_FLAG_TIMESTAMP_COPY | V4L2_BUF_FLAG_TSTAMP_SRC_SOE), HostStamp::arrival_end);
  // Webcams: it is called so, but is when the first packet came.
  EXPECT_EQ(stamp_with("uvcvideo", exposure), HostStamp::arrival_start);
  kernel->parameters["hwtimestamps"] = "0";
  EXPECT_EQ(stamp_with("uvcvideo", exposure), HostStamp::arrival_start);
  kernel->parameters["hwtimestamps"] = "1";
  EXPECT_EQ(stamp_with("uvcvideo", exposure), HostStamp::exposure_start);
}

TEST_F(VideoCamera, RowsMayHaveGaps) {
  kernel->padding = 24;
  CameraConfig config;
  config.region = Region{0, 0, 100, 40};
  stream(config);
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().row_bytes, 124U);
  EXPECT_EQ(delivery.frame.pixels().size(), 124U * 40);
  const auto sequence = static_cast<std::uint32_t>(delivery.frame.facts().frame_id);
  EXPECT_EQ(delivery.frame.pixels()[777], FakeVideoKernel::pixel(sequence, 777));
}

TEST_F(VideoCamera, WhatTheCameraLacksIsSaidWithWhatItHas) {
  open();
  CameraConfig config;
  config.pixel_format = "Mono16";
  EXPECT_THAT(error_of(config), HasSubstr("it has Mono8, BayerRG8 and BayerRG12"));
  config = {};
  config.region = Region{0, 0, 1280, 1024};
  EXPECT_THAT(error_of(config), HasSubstr("16 x 16 to 640 x 480 in steps of 2 x 2"));
  config = {};
  config.exposure_us = 1e6;
  EXPECT_THAT(error_of(config), HasSubstr("100.00 to 500000.00"));
  config = {};
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  EXPECT_THAT(error_of(config), HasSubstr("no trigger"));
  config = {};
  config.gain = 1000.0;
  EXPECT_THAT(error_of(config), HasSubstr("0.00 to 100.00"));
  kernel->can_cut = false;
  config = {};
  config.region = Region{8, 0, 64, 48};
  EXPECT_THAT(error_of(config), HasSubstr("offset"));
  config.region->x = 0;
  configure(config);
  kernel->controls.clear();
  config = {};
  config.exposure_us = 1000.0;
  EXPECT_THAT(error_of(config), HasSubstr("leave exposure_us out"));
  kernel->can_set_rate = false;
  config = {};
  config.frame_rate = 10.0;
  EXPECT_THAT(error_of(config), HasSubstr("leave frame_rate out"));
}

TEST_F(VideoCamera, ARateThatIsNotReachedIsNoted) {
  open();
  CameraConfig config;
  config.frame_rate = 400.0;
  setup = configure(config);
  ASSERT_EQ(setup.notes.size(), 1U);
  EXPECT_THAT(setup.notes[0], HasSubstr("100.00"));
}

TEST_F(VideoCamera, WhyItCannotBeOpenedIsSaid) {
  EXPECT_THAT(camera->open("/dev/video99").error().message(), HasSubstr("there is /dev/video7"));
  kernel->open_answer = -EACCES;
  EXPECT_THAT(camera->open("/dev/video7").error().message(), HasSubstr("usermod -aG video"));
  EXPECT_THAT(camera->open("V4L2-0815").error().message(), HasSubstr("/dev/video7 left out"));
  kernel->open_answer = 0;
  kernel->is_held = true;
  open();
  EXPECT_THAT(error_of({}), HasSubstr("another program"));
  kernel->is_held = false;
  configure({});
}

TEST_F(VideoCamera, GapsOfTheSequenceAreFramesThatNeverCame) {
  stream();
  next();
  kernel->skip = 3;
  std::uint64_t missing = 0;
  for (int i = 0; i < 4; ++i) missing += next().frame.facts().missing_before;
  EXPECT_EQ(missing, 3U);
  EXPECT_EQ(camera->counters().missing, 3U);
}

TEST_F(VideoCamera, DamagedAndShortFramesAreFlaggedAndHaveNoPixels) {
  stream();
  next();
  kernel->damages_next = true;
  Delivery delivery = next();
  while (delivery.frame.is_whole()) delivery = next();
  EXPECT_EQ(delivery.frame.facts().status, FrameStatus::device_error);
  EXPECT_THAT(delivery.frame.pixels(), IsEmpty());
  kernel->shortens_next = true;
  do {
    delivery = next();
  } while (delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().status, FrameStatus::incomplete);
  EXPECT_THAT(delivery.frame.pixels(), IsEmpty());
  EXPECT_EQ(camera->counters().damaged(), 2U);
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(VideoCamera, ACameraThatIsUnpluggedComesBackElsewhere) {
  CameraConfig config;
  config.pixel_format = "BayerRG8";
  config.region = Region{0, 0, 200, 100};
  stream(config);
  Delivery kept = next();
  const std::uint8_t first = kept.frame.pixels()[0];
  kernel->unplug();
  const Delivery lost = next();
  ASSERT_EQ(lost.kind, Kind::lost);
  EXPECT_THAT(lost.text, HasSubstr("unplugged"));
  EXPECT_EQ(camera->state(), CameraState::streaming);
  EXPECT_EQ(next(10 * ms).kind, Kind::nothing);
  EXPECT_EQ(kept.frame.pixels()[0], first);
  kept.frame.give_back();
  kernel->plug_in("/dev/video9");
  ASSERT_EQ(next().kind, Kind::back);
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().width, 200);
  EXPECT_EQ(delivery.frame.facts().pixel_format, "BayerRG8");
  EXPECT_EQ(camera->counters().losses, 1U);
  EXPECT_EQ(camera->counters().returns, 1U);
}

TEST_F(VideoCamera, AnotherDeviceFileOfItsNameIsNotTakenForIt) {
  kernel->twin = "/dev/video5";
  stream();
  next();
  kernel->unplug();
  ASSERT_EQ(next().kind, Kind::lost);
  EXPECT_THAT(next().text, HasSubstr("another program uses it"));
  kernel->twin_refusals = 0;
  kernel->plug_in("/dev/video9");
  ASSERT_EQ(next().kind, Kind::back);
  EXPECT_TRUE(next().frame.is_whole());
  EXPECT_GT(kernel->twin_refusals, 0);
  // From now on it is looked for there first.
  kernel->twin_refusals = 0;
  kernel->breaks_off = true;
  Delivery delivery = next();
  while (delivery.kind == Kind::frame) delivery = next();
  ASSERT_EQ(delivery.kind, Kind::lost);
  ASSERT_EQ(next().kind, Kind::back);
  EXPECT_EQ(kernel->twin_refusals, 0);
}

TEST_F(VideoCamera, WhyACameraThatIsBackCannotBeHadIsSaidOnceAndItKeepsItsOwnSettings) {
  CameraConfig config;
  config.exposure_us = 2500.0;
  stream(config);
  next();
  kernel->unplug();
  ASSERT_EQ(next().kind, Kind::lost);
  // It comes with the settings that it is switched on with, and cannot do what it could before.
  kernel->controls.at(V4L2_CID_EXPOSURE_AUTO).value = V4L2_EXPOSURE_APERTURE_PRIORITY;
  kernel->controls.at(V4L2_CID_EXPOSURE_ABSOLUTE).value = 150;
  kernel->most_width = 160;
  kernel->plug_in("/dev/video9");
  const Delivery size = next();
  ASSERT_EQ(size.kind, Kind::refused);
  EXPECT_THAT(size.text,
              HasSubstr("Test-Camera-V4L2-0815: the camera cannot be had again yet: the camera came back with "
                        "another image size; set its size"));
  EXPECT_EQ(next(300 * ms).kind, Kind::nothing) << "it was said";
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_ABSOLUTE), 150);
  kernel->is_held = true;
  EXPECT_THAT(next().text, HasSubstr("another program uses it"));
  kernel->is_held = false;
  kernel->open_answer = -EACCES;
  EXPECT_THAT(next().text, HasSubstr("/dev/video9 left out"));
  kernel->open_answer = 0;
  kernel->most_width = 640;
  kernel->plug_in("/dev/video9");
  ASSERT_EQ(next().kind, Kind::back);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_ABSOLUTE), 25);
  camera->close();
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_APERTURE_PRIORITY);
  EXPECT_EQ(control(V4L2_CID_EXPOSURE_ABSOLUTE), 150);
}

TEST_F(VideoCamera, ACameraThatCannotBeSetUpAgainCanBeAskedToStartAgain) {
  stream();
  next();
  kernel->unplug();
  ASSERT_EQ(next().kind, Kind::lost);
  ASSERT_TRUE(camera->stop().has_value());
  kernel->most_width = 160;
  kernel->plug_in("/dev/video7");
  for (int i = 0; i < 2; ++i) {
    const auto started = camera->start();
    ASSERT_FALSE(started.has_value());
    EXPECT_THAT(started.error().message(), HasSubstr("another image size"));
  }
  kernel->most_width = 640;
  kernel->plug_in("/dev/video7");
  ASSERT_TRUE(camera->start().has_value());
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(VideoCamera, AStreamThatBreaksOffOrChangesIsBegunAgain) {
  stream();
  next();
  kernel->breaks_off = true;
  Delivery delivery = next();
  while (delivery.kind == Kind::frame) delivery = next();
  ASSERT_EQ(delivery.kind, Kind::lost);
  EXPECT_THAT(delivery.text, HasSubstr("broke off"));
  ASSERT_EQ(next().kind, Kind::back);
  EXPECT_TRUE(next().frame.is_whole());
  kernel->has_changed = true;
  ASSERT_EQ(next().kind, Kind::lost);
  ASSERT_EQ(next().kind, Kind::back);
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(VideoCamera, WhileAllBuffersAreLentItWaits) {
  for (const bool is_error : {true, false}) {
    kernel->is_error_while_dry = is_error;
    CameraConfig config;
    config.buffers = 2;
    stream(config);
    {
      const Delivery one = next();
      const Delivery two = next();
      EXPECT_EQ(next(50 * ms).kind, Kind::nothing);
      ASSERT_TRUE(camera->stop().has_value());
      ASSERT_TRUE(camera->start().has_value());
      EXPECT_EQ(next(50 * ms).kind, Kind::nothing);
      ASSERT_TRUE(camera->stop().has_value());
      EXPECT_THAT(error_of(config), HasSubstr("still lent"));
    }
    configure(config);
    ASSERT_TRUE(camera->start().has_value());
    EXPECT_TRUE(next().frame.is_whole());
    camera->close();
  }
}

// The kernel takes no format while a buffer is lent.
TEST_F(VideoCamera, PutsItsFormatBackWhenTheLastLentFrameComes) {
  CameraConfig config;
  config.pixel_format = "BayerRG12";
  config.region = Region{10, 20, 100, 50};
  stream(config);
  {
    const Delivery lent = next();
    ASSERT_TRUE(lent.frame.is_whole());
    camera->close();
    EXPECT_EQ(kernel->open_files(), 1);
  }
  EXPECT_EQ(kernel->open_files(), 0);
  open();
  setup = configure({});
  EXPECT_EQ(setup.pixel_format, "Mono8");
  EXPECT_EQ(setup.width, 320);
}

TEST_F(VideoCamera, GivesBackWhatItTook) {
  stream();
  next();
  camera->close();
  EXPECT_EQ(kernel->open_files(), 0);
  EXPECT_EQ(kernel->mapped(), 0);
}

TEST_F(VideoCamera, NothingElseIsTakenForACamera) {
  kernel->fourccs = {V4L2_PIX_FMT_YUYV};
  open();
  EXPECT_THAT(error_of({}), HasSubstr("it has none"));
  kernel->most_buffers = 1;
  kernel->fourccs = {V4L2_PIX_FMT_GREY};
  EXPECT_THAT(error_of({}), HasSubstr("only 1 buffers"));
}

TEST(VideoFormats, GoBothWays) {
  EXPECT_EQ(name_of_fourcc(V4L2_PIX_FMT_SGBRG10), "BayerGB10");
  EXPECT_EQ(name_of_fourcc(V4L2_PIX_FMT_YUYV), "");
  for (const char* name : {"Mono8", "Mono12", "BayerRG16", "BayerBG14", "RGB8"})
    EXPECT_EQ(name_of_fourcc(fourcc_of(name)), name);
  EXPECT_EQ(fourcc_of("Mono12Packed"), 0U);
}

}  // namespace
}  // namespace rigcal::camera
