// GigE Vision cameras through Aravis: what only they can do, and what can happen to them.
#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <utility>

#include "drivers/camera/aravis/aravis_backend.h"
#include "tests/drivers/camera/virtual_camera.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::camera {
namespace {

using testing::Contains;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using Kind = Delivery::Kind;

constexpr std::int64_t ms = 1'000'000;

class AravisCamera : public testing::Test {
 protected:
  void serve() {
    server.reset();
    auto started = sim::CameraServer::start({device});
    ASSERT_TRUE(started.has_value()) << started.error().message();
    server = *std::move(started);
  }
  std::unique_ptr<Camera> make() {
    AravisOptions made = options;
    if (keeps_settings) made.settings_folder = (scratch / "cameras").string();
    return AravisBackend(made).make();
  }
  void open() {
    camera = make();
    const auto opened = camera->open(address_of(device));
    ASSERT_TRUE(opened.has_value()) << opened.error().message();
  }
  CameraSetup configure(const CameraConfig& config) {
    auto configured = camera->configure(config);
    EXPECT_TRUE(configured.has_value()) << configured.error().message();
    return configured ? *configured : CameraSetup{};
  }
  void stream(const CameraConfig& config) {
    open();
    setup = configure(config);
    const auto started = camera->start();
    ASSERT_TRUE(started.has_value()) << started.error().message();
  }
  Delivery next(std::int64_t timeout_ns = 3000 * ms) {
    auto delivery = camera->next(timeout_ns);
    EXPECT_TRUE(delivery.has_value());
    return delivery ? *std::move(delivery) : Delivery{};
  }
  /// Waits for a delivery of that kind; frames that come before it are dropped.
  Delivery wait_for(Kind kind, int seconds) {
    for (int i = 0; i < 10 * seconds; ++i) {
      Delivery delivery = next(100 * ms);
      if (delivery.kind == kind) return delivery;
    }
    ADD_FAILURE() << "it did not come";
    return {};
  }
  /// As another program reads and sets it.
  std::vector<std::string> features() {
    ArvCamera* other = arv_camera_new(address_of(device).c_str(), nullptr);
    std::vector<std::string> values;
    for (const char* name : {"PixelFormat", "Width", "Height", "OffsetX", "OffsetY", "ExposureTime", "ExposureAuto",
                             "AcquisitionFrameRate", "AcquisitionFrameRateEnable", "TriggerMode", "TriggerSource",
                             "TriggerActivation", "TriggerDelay", "LineSelector", "LineMode", "ChunkModeActive",
                             "ChunkSelector", "GevSCPSPacketSize", "GevSCPD"}) {
      ArvGcNode* node = arv_device_get_feature(arv_camera_get_device(other), name);
      values.push_back(std::string(name) + "=" +
                       arv_gc_feature_node_get_value_as_string(ARV_GC_FEATURE_NODE(node), nullptr));
    }
    g_object_unref(other);
    return values;
  }
  void set_by_hand(const std::vector<std::pair<std::string, std::string>>& settings) {
    ArvCamera* other = arv_camera_new(address_of(device).c_str(), nullptr);
    for (const auto& [name, value] : settings) {
      ArvGcNode* node = arv_device_get_feature(arv_camera_get_device(other), name.c_str());
      GError* wrong = nullptr;
      arv_gc_feature_node_set_value_from_string(ARV_GC_FEATURE_NODE(node), value.c_str(), &wrong);
      EXPECT_EQ(wrong, nullptr) << name;
    }
    g_object_unref(other);
  }
  std::string error_of(const CameraConfig& config) {
    const auto configured = camera->configure(config);
    EXPECT_FALSE(configured.has_value());
    return configured ? "" : configured.error().message();
  }

  sim::ServedCamera device = virtual_camera(42, "00C0DE42");
  std::unique_ptr<sim::CameraServer> server;
  std::filesystem::path scratch = scratch_folder("aravis_camera");
  AravisOptions options;
  bool keeps_settings = false;
  std::unique_ptr<Camera> camera;
  CameraSetup setup;
};

TEST_F(AravisCamera, SetsUpWhatIsAskedAndSaysWhatItGot) {
  serve();
  open();
  CameraConfig config = small_config();
  config.pixel_format = "BayerRG12";
  config.exposure_us = 2500.0;
  config.gain = 6.0;
  config.frame_rate = 12.0;
  config.packet_bytes = 1500;
  config.packet_delay_ns = 1000;
  config.strobe = "Line1";
  setup = configure(config);
  EXPECT_EQ(setup.pixel_format, "BayerRG12");
  EXPECT_EQ(setup.width, 256);
  EXPECT_EQ(setup.image_bytes, 256U * 128 * 2);
  EXPECT_NEAR(*setup.exposure_us, 2500.0, 0.1);
  EXPECT_NEAR(*setup.gain, 6.0, 1e-3);
  EXPECT_NEAR(*setup.frame_rate, 12.0, 1e-3);
  EXPECT_EQ(setup.packet_bytes, 1500);
  ASSERT_TRUE(camera->start().has_value());
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_NEAR(*delivery.frame.facts().exposure_us, 2500.0, 0.1);
  const std::size_t pixel = 2 * (100 * 256 + 50);
  const ByteView pixels = delivery.frame.pixels();
  const auto number = delivery.frame.facts().frame_id - 1;
  EXPECT_EQ(pixels[pixel] | pixels[pixel + 1] << 8, sim::TestPattern::value(number, 50, 100, 12));
}

TEST_F(AravisCamera, PacketsAreAsLargeAsComesThrough) {
  serve();
  open();
  // The loopback network takes any packet, so the camera's own limit counts.
  setup = configure(small_config());
  EXPECT_GT(*setup.packet_bytes, 8000);
  CameraConfig config = small_config();
  config.packet_bytes = 100'000;
  EXPECT_THAT(error_of(config), HasSubstr("packet size"));
}

TEST_F(AravisCamera, WhatTheCameraLacksIsSaidWithWhatItHas) {
  serve();
  open();
  CameraConfig config = small_config();
  config.pixel_format = "Mono16";
  EXPECT_THAT(error_of(config), HasSubstr("it has BayerRG8, BayerRG12 and Mono8"));
  config = small_config();
  config.exposure_us = 20e6;
  EXPECT_THAT(error_of(config), HasSubstr("15.00 to 10000000.00"));
  config = small_config();
  config.trigger = TriggerConfig{"Line7", false, 0.0};
  EXPECT_THAT(error_of(config), HasSubstr("it has Line0, Line2 and Software"));
  config = small_config();
  config.strobe = "Line9";
  EXPECT_THAT(error_of(config), HasSubstr("Line0, Line1 and Line2"));
  config = small_config();
  config.ptp = true;
  EXPECT_THAT(error_of(config), HasSubstr("PTP"));
  config = small_config();
  config.region = Region{0, 0, 4000, 128};
  EXPECT_THAT(error_of(config), HasSubstr("to 1280 pixels"));
  configure(small_config());
}

TEST_F(AravisCamera, ACameraThatAnotherProgramHoldsIsSaidWithItsHolder) {
  serve();
  open();
  const auto second = make();
  const auto opened = second->open(address_of(device));
  ASSERT_FALSE(opened.has_value());
  EXPECT_THAT(opened.error().message(), HasSubstr("held by another program on 127.0.0.1"));
  camera->close();
  EXPECT_TRUE(second->open(address_of(device)).has_value());
}

TEST_F(AravisCamera, AnAddressWhereNobodyAnswersIsAbsent) {
  serve();
  camera = make();
  const auto opened = camera->open("127.0.8.99");
  ASSERT_FALSE(opened.has_value());
  EXPECT_THAT(opened.error().message(), HasSubstr("127.0.8.99"));
  EXPECT_THAT(opened.error().message(), HasSubstr(id_of(device)));
}

TEST_F(AravisCamera, ClosesWithTheSettingsThatItFound) {
  serve();
  // Somebody has set it up by hand.
  set_by_hand({{"Width", "640"}, {"Height", "480"}, {"OffsetX", "32"}, {"OffsetY", "16"}, {"ExposureTime", "777"}});
  set_by_hand({{"TriggerSource", "Line2"}, {"TriggerMode", "On"}, {"GevSCPSPacketSize", "2000"}});
  const std::vector<std::string> before = features();
  open();
  CameraConfig ours = small_config();
  ours.pixel_format = "Mono8";
  ours.region = Region{64, 64, 128, 64};
  ours.exposure_us = 3000.0;
  ours.trigger = TriggerConfig{"Line0", true, 20.0};
  ours.strobe = "Line1";
  ours.packet_delay_ns = 5000;
  configure(ours);
  EXPECT_NE(features(), before);
  configure(small_config());
  camera->close();
  EXPECT_THAT(camera->notes(), IsEmpty());
  EXPECT_EQ(features(), before);
}

TEST_F(AravisCamera, WhatACrashLeftIsMendedAtTheNextStart) {
  keeps_settings = true;
  serve();
  const std::vector<std::string> before = features();
  CameraConfig config = small_config();
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  stream(config);
  const std::vector<std::string> at_the_crash = features();
  EXPECT_NE(at_the_crash, before);
  std::filesystem::copy(scratch / "cameras", scratch / "at_the_crash");
  camera->close();
  EXPECT_EQ(features(), before);
  EXPECT_TRUE(std::filesystem::is_empty(scratch / "cameras"));
  // As if it had crashed instead: the camera waits for triggers, and the file is there.
  set_by_hand({{"Width", "256"}, {"Height", "128"}, {"TriggerMode", "On"}, {"ChunkModeActive", "true"}});
  std::filesystem::remove_all(scratch / "cameras");
  std::filesystem::rename(scratch / "at_the_crash", scratch / "cameras");
  open();
  EXPECT_THAT(camera->notes(), Contains(HasSubstr("did not end as it should")));
  EXPECT_TRUE(std::filesystem::is_empty(scratch / "cameras"));
  EXPECT_EQ(features(), before);
}

TEST_F(AravisCamera, WhatAMuteCameraKeepsIsMendedAtTheNextStart) {
  keeps_settings = true;
  serve();
  const std::vector<std::string> before = features();
  CameraConfig config = small_config();
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  stream(config);
  server->fall_silent(0, std::numeric_limits<std::int64_t>::max());
  camera->close();  // Before its heartbeat is missed.
  EXPECT_THAT(camera->notes(), Contains(HasSubstr("could not be put back")));
  EXPECT_FALSE(std::filesystem::is_empty(scratch / "cameras"));
  serve();
  set_by_hand({{"Width", "256"}, {"Height", "128"}, {"TriggerMode", "On"}, {"ChunkModeActive", "true"}});
  open();
  EXPECT_THAT(camera->notes(), Contains(HasSubstr("did not end as it should")));
  EXPECT_TRUE(std::filesystem::is_empty(scratch / "cameras"));
  EXPECT_EQ(features(), before);
}

TEST_F(AravisCamera, ACameraInTriggerModeRunsFreeWhereNoTriggerIsAsked) {
  serve();
  CameraConfig config = small_config();
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  stream(config);
  EXPECT_EQ(next(200 * ms).kind, Kind::nothing);
  ASSERT_TRUE(camera->stop().has_value());
  configure(small_config());
  ASSERT_TRUE(camera->start().has_value());
  EXPECT_TRUE(next().frame.is_whole());
}

TEST_F(AravisCamera, EveryPulseOfTheLineIsOneFrame) {
  serve();
  CameraConfig config = small_config();
  config.trigger = TriggerConfig{"Line0", false, 100.0};
  stream(config);
  for (int i = 0; i < 3; ++i) {
    const auto now = std::chrono::steady_clock::now().time_since_epoch();
    const std::int64_t rise_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count();
    server->pulse({0, rise_ns, rise_ns + ms, i});
    const Delivery delivery = next();
    ASSERT_EQ(delivery.kind, Kind::frame);
    EXPECT_TRUE(delivery.frame.is_whole());
    EXPECT_GT(delivery.frame.facts().host_stamp_ns, rise_ns);
  }
  EXPECT_EQ(next(100 * ms).kind, Kind::nothing);
}

TEST_F(AravisCamera, WithoutADelayItIsTheLeastThatTheCameraTakes) {
  device.device.least_trigger_delay_us = 9.0;
  serve();
  open();
  CameraConfig config = small_config();
  EXPECT_FALSE(configure(config).trigger_delay_us.has_value());
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  setup = configure(config);
  ASSERT_TRUE(setup.trigger_delay_us.has_value());
  EXPECT_NEAR(*setup.trigger_delay_us, 9.0, 1e-3);
  EXPECT_THAT(setup.notes, Contains(HasSubstr("no sooner than 9.00 us after a pulse")));
  config.trigger->delay_us = 20.0;
  EXPECT_NEAR(configure(config).trigger_delay_us.value_or(0.0), 20.0, 1e-3);
  config.trigger->delay_us = 5.0;
  EXPECT_THAT(error_of(config), HasSubstr("a trigger delay of 5.00 us is not possible"));
}

TEST_F(AravisCamera, AnExposureThatTheCameraChoosesIsSaidToVary) {
  serve();
  set_by_hand({{"ExposureAuto", "Continuous"}});
  open();
  CameraConfig config = small_config();
  config.exposure_us.reset();
  EXPECT_TRUE(configure(config).exposure_varies);
  config.exposure_us = 1000.0;
  EXPECT_FALSE(configure(config).exposure_varies);
}

TEST_F(AravisCamera, PulsesThatComeEarlyByTheirJitterAreFramesToo) {
  serve();
  CameraConfig config = small_config();
  config.frame_rate = 10.0;
  config.trigger = TriggerConfig{"Line0", false, 0.0};
  stream(config);
  EXPECT_FALSE(setup.frame_rate.has_value());
  EXPECT_THAT(setup.notes, Not(Contains(HasSubstr("frame rate"))));
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  const std::int64_t first_ns = std::chrono::duration_cast<std::chrono::nanoseconds>(now).count() + 50 * ms;
  for (int i = 0; i < 5; ++i) {
    const std::int64_t rise_ns = first_ns + i * 100 * ms - (i % 2 == 1 ? 2 * ms : 0);
    server->pulse({0, rise_ns, rise_ns + ms, i});
  }
  for (int i = 0; i < 5; ++i) EXPECT_EQ(next().kind, Kind::frame) << i;
}

// Aravis' own has a rate, and no switch for it.
TEST_F(AravisCamera, ARateThatCannotBeSwitchedOffIsAsHighAsItCanBeForTriggers) {
  ArvGvFakeCamera* fake = arv_gv_fake_camera_new("127.0.0.1", "GV4712");
  ASSERT_TRUE(arv_gv_fake_camera_is_running(fake));
  camera = make();
  ASSERT_TRUE(camera->open("127.0.0.1").has_value());
  CameraConfig config;
  config.pixel_format = "Mono8";
  config.frame_rate = 5.0;
  config.packet_bytes = 1500;
  EXPECT_NEAR(*configure(config).frame_rate, 5.0, 0.01);
  config.trigger = TriggerConfig{"Software", false, 0.0};
  EXPECT_THAT(configure(config).notes, Not(Contains(HasSubstr("AcquisitionFrameRate"))));
  ArvCamera* other = arv_camera_new("127.0.0.1", nullptr);
  EXPECT_GT(arv_camera_get_frame_rate(other, nullptr), 100.0);
  g_object_unref(other);
  camera->close();
  g_object_unref(fake);
}

TEST_F(AravisCamera, StampsThatStandStillAreNone) {
  device.device.clock_drift = -1.0;
  device.device.clock_start_ns = 7'000 * ms;
  serve();
  stream(small_config());
  next();
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(next().frame.facts().device_stamp_ns.has_value());
}

TEST_F(AravisCamera, LostPacketsAreAskedForAgain) {
  device.faults.loss = 0.02;
  options.frame_retention_us = 1'000'000;  // The tests' machine may be busy with something else.
  serve();
  CameraConfig config = small_config();
  config.packet_bytes = 1500;
  config.buffers = 64;
  stream(config);
  int whole = 0;
  for (int i = 0; i < 30; ++i) whole += next().frame.is_whole() ? 1 : 0;
  EXPECT_GE(whole, 27);
  EXPECT_GT(camera->counters().resent_packets, 0U);
}

TEST_F(AravisCamera, WithoutResendADamagedFrameIsFlaggedAndHasNoPixels) {
  device.faults.loss = 0.01;
  options.resend = false;
  options.frame_retention_us = 60'000;
  serve();
  CameraConfig config = small_config();
  config.packet_bytes = 1500;
  stream(config);
  std::uint64_t damaged = 0;
  sim::TestPattern pattern;
  for (int i = 0; i < 50; ++i) {
    const Delivery delivery = next();
    ASSERT_EQ(delivery.kind, Kind::frame);
    const FrameFacts& facts = delivery.frame.facts();
    if (!delivery.frame.is_whole()) {
      ++damaged;
      EXPECT_EQ(facts.status, FrameStatus::incomplete);
      EXPECT_TRUE(delivery.frame.pixels().empty());
      continue;
    }
    sim::FrameWish wish;
    wish.number = facts.frame_id - 1;
    wish.pixel_format = "BayerRG8";
    wish.width = facts.width;
    wish.height = facts.height;
    std::vector<std::uint8_t> image;
    pattern.make(wish, image);
    EXPECT_TRUE(std::equal(image.begin(), image.end(), delivery.frame.pixels().begin())) << "passed as good";
  }
  EXPECT_GT(damaged, 0U);
  const CameraCounters counters = camera->counters();
  EXPECT_EQ(counters.damaged(), damaged);
  EXPECT_EQ(counters.whole(), 50 - damaged);
  EXPECT_EQ(counters.resent_packets, 0U);
}

TEST_F(AravisCamera, ACameraThatVanishesIsSaidAndComesBackAsItWasSetUp) {
  serve();
  CameraConfig config = small_config();
  config.pixel_format = "Mono8";
  config.exposure_us = 1234.0;
  stream(config);
  EXPECT_TRUE(next().frame.is_whole());
  server.reset();
  // Its heartbeat has to be missed for some seconds.
  const Delivery lost = wait_for(Kind::lost, 20);
  EXPECT_THAT(lost.text, HasSubstr(id_of(device)));
  EXPECT_EQ(camera->state(), CameraState::streaming);
  EXPECT_FALSE(lost.frame.is_whole());
  EXPECT_EQ(next(10 * ms).kind, Kind::nothing);
  const int width = std::exchange(device.device.width, 128);
  serve();  // A smaller sensor.
  EXPECT_THAT(wait_for(Kind::refused, 20).text, HasSubstr("to 128 pixels"));
  device.device.width = width;
  serve();  // Another camera of the same name, with its own settings.
  EXPECT_THAT(wait_for(Kind::back, 20).text, HasSubstr("back"));
  const Delivery delivery = next();
  ASSERT_TRUE(delivery.frame.is_whole());
  EXPECT_EQ(delivery.frame.facts().pixel_format, "Mono8");
  EXPECT_NEAR(*delivery.frame.facts().exposure_us, 1234.0, 0.1);
  EXPECT_EQ(camera->counters().losses, 1U);
  EXPECT_EQ(camera->counters().returns, 1U);
  ASSERT_TRUE(camera->stop().has_value());
}

TEST_F(AravisCamera, CanBeStoppedAndClosedWhileItIsGone) {
  keeps_settings = true;
  serve();
  stream(small_config());
  EXPECT_TRUE(next().frame.is_whole());
  server.reset();
  wait_for(Kind::lost, 20);
  EXPECT_TRUE(camera->stop().has_value());
  EXPECT_FALSE(camera->start().has_value());
  camera->close();
  EXPECT_THAT(camera->notes(), Contains(HasSubstr("could not be put back")));
  // The next start mends it.
  serve();
  open();
  EXPECT_THAT(camera->notes(), Contains(HasSubstr("did not end as it should")));
}

}  // namespace
}  // namespace rigcal::camera
