// A camera of the kernel's module `vivid`, with the faults that it can be asked for. In the virtual machine of
// tests/hil.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "core/records/pixel_format.h"
#include "drivers/camera/v4l2/video_backend.h"

namespace rigcal::camera {
namespace {

using testing::HasSubstr;
using Kind = Delivery::Kind;
namespace fs = std::filesystem;

constexpr std::int64_t ms = 1'000'000;

class V4l2Vivid : public testing::Test {
 protected:
  void SetUp() override {
    const char* named = std::getenv("RIGCAL_TEST_V4L2");
    if (named == nullptr) GTEST_SKIP() << "NOT TESTED: set RIGCAL_TEST_V4L2=/dev/videoN to a camera of vivid";
    path = named;
    const auto opened = camera->open(path);
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
    if (camera->identity().vendor != "vivid") GTEST_SKIP() << "NOT TESTED: " << path << " is no camera of vivid";
  }
  void start(const std::string& format = "Mono8") {
    CameraConfig config;
    config.pixel_format = format;
    config.region = Region{0, 0, 640, 480};
    const auto configured = camera->configure(config);
    ASSERT_TRUE(configured.has_value()) << format << ": " << configured.error().message();
    setup = *configured;
    const auto started = camera->start();
    ASSERT_TRUE(started.has_value()) << started.error().message();
  }
  Delivery next(std::int64_t timeout_ns = 3000 * ms) {
    auto delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery.has_value());
    return delivery ? *std::move(delivery) : Delivery{};
  }
  /// Frames that come before it are dropped.
  Delivery wait_for(Kind kind) {
    for (int i = 0; i < 200; ++i) {
      Delivery delivery = next(100 * ms);
      if (delivery.kind == kind) return delivery;
    }
    ADD_FAILURE() << "it did not come";
    return {};
  }
  void control(const std::string& name, int value) {
    const std::string command = "v4l2-ctl --device " + path + " --set-ctrl " + name + "=" + std::to_string(value);
    EXPECT_EQ(std::system(command.c_str()), 0) << command;
  }

  std::string path;
  std::unique_ptr<Camera> camera = VideoBackend().make();
  CameraSetup setup;
};

TEST_F(V4l2Vivid, SendsGreyAndBayerOf8To16Bits) {
  for (const char* format : {"Mono8", "Mono10", "Mono12", "Mono16", "BayerRG8", "BayerGR8", "BayerGB8", "BayerBG8",
                             "BayerRG10", "BayerRG12", "BayerRG16", "BayerBG16", "RGB8"}) {
    ASSERT_NO_FATAL_FAILURE(start(format));
    {
      const Delivery delivery = next();
      ASSERT_TRUE(delivery.frame.is_whole()) << format;
      const PixelFormat layout = *parse_pixel_format(format);
      EXPECT_EQ(delivery.frame.pixels().size(),
                640U * 480 * static_cast<std::size_t>(layout.channels() * layout.stored_bits() / 8))
          << format;
      EXPECT_EQ(delivery.frame.facts().pixel_format, format);
    }
    ASSERT_TRUE(camera->stop().has_value());
  }
}

TEST_F(V4l2Vivid, DroppedBuffersAreFramesThatNeverCame) {
  start();
  next();
  control("percentage_of_dropped_buffers", 50);
  for (int i = 0; i < 20; ++i) next();
  control("percentage_of_dropped_buffers", 0);
  EXPECT_GT(camera->counters().missing, 0U);
}

TEST_F(V4l2Vivid, AFrameWithTheErrorFlagHasNoPixels) {
  start();
  next();
  control("inject_v4l2_buf_flag_error", 1);
  Delivery delivery;
  for (int i = 0; i < 60 && delivery.frame.facts().status != FrameStatus::device_error; ++i) delivery = next();
  EXPECT_EQ(delivery.frame.facts().status, FrameStatus::device_error);
  EXPECT_TRUE(delivery.frame.pixels().empty());
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(V4l2Vivid, AStreamThatBreaksOffIsBegunAgain) {
  start();
  next();
  control("inject_fatal_streaming_error", 1);
  EXPECT_THAT(wait_for(Kind::lost).text, HasSubstr("broke off"));
  wait_for(Kind::back);
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(V4l2Vivid, ADriverThatIsTakenAwayAndComesBackIsNoticedWithinASecond) {
  ASSERT_NO_FATAL_FAILURE(start("BayerRG8"));
  next();
  const fs::path device = fs::canonical(fs::path("/sys/class/video4linux") / fs::path(path).filename() / "device");
  const std::string name = device.filename().string();
  const fs::path driver = fs::canonical(device / "driver");
  const auto before = std::chrono::steady_clock::now();
  std::ofstream(driver / "unbind") << name;
  EXPECT_THAT(wait_for(Kind::lost).text, HasSubstr("unplugged"));
  EXPECT_LT(std::chrono::steady_clock::now() - before, std::chrono::seconds(1));
  EXPECT_EQ(next(200 * ms).kind, Kind::nothing);
  std::ofstream(driver / "bind") << name;
  wait_for(Kind::back);
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().pixel_format, "BayerRG8");
  EXPECT_EQ(delivery.frame.facts().width, 640);
  EXPECT_EQ(camera->counters().losses, 1U);
}

}  // namespace
}  // namespace rigcal::camera
