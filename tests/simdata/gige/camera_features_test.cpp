// What a virtual camera does with its features.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <limits>

#include "drivers/gige_codec/pixel_code.h"
#include "simdata/gige/brightness.h"
#include "simdata/gige/camera_description.h"
#include "tests/simdata/gige/camera_desk.h"

namespace rigcal::sim {
namespace {

namespace bootstrap = gige::bootstrap;
using gige::Status;
using testing::HasSubstr;
using testing::Not;

class CameraFeatures : public testing::Test {
 protected:
  void SetUp() override {
    desk.take_control();
    desk.open_stream();
  }
  CameraDesk desk;
};

TEST_F(CameraFeatures, TheDescriptionIsWhereTheUrlSays) {
  const auto url = desk.ask(desk.host, gige::ReadMemoryRequest{bootstrap::kFirstUrl, 512});
  const auto& bytes = std::get<gige::ReadMemoryAck>(*url->ack).bytes;
  unsigned address = 0;
  unsigned size = 0;
  ASSERT_EQ(std::sscanf(reinterpret_cast<const char*>(bytes.data()), "Local:%*[^;];%X;%X", &address, &size), 2);
  std::string text;
  while (text.size() < size) {
    const auto part = desk.ask(desk.host, gige::ReadMemoryRequest{address + static_cast<unsigned>(text.size()), 4});
    ASSERT_EQ(part->status, Status::success);
    const auto& four = std::get<gige::ReadMemoryAck>(*part->ack).bytes;
    text.append(four.begin(), four.end());
  }
  text.resize(size);
  EXPECT_TRUE(text == describe_camera(desk_camera().pixel_formats));
  EXPECT_THAT(text, HasSubstr("</RegisterDescription>"));
  EXPECT_THAT(text, HasSubstr("BayerRG12"));
  EXPECT_THAT(text, Not(HasSubstr("Mono12")));
  EXPECT_THAT(text, Not(HasSubstr("@")));
}

TEST_F(CameraFeatures, SizesKeepWithinTheSensor) {
  EXPECT_EQ(desk.read(Feature::width_max), 1280U);
  EXPECT_EQ(desk.write(Feature::offset_x, 8), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::width, 1284), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::width, 644), Status::invalid_parameter);  // No multiple of 8.
  EXPECT_EQ(desk.write(Feature::width, 24), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::width, 640), Status::success);
  EXPECT_EQ(desk.write(Feature::offset_x, 640), Status::success);
  EXPECT_EQ(desk.write(Feature::offset_x, 648), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::width, 648), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::width, 0xFFFF'FFF8), Status::invalid_parameter);
}

TEST_F(CameraFeatures, ThePayloadFollowsFromSizeFormatAndChunks) {
  EXPECT_EQ(desk.read(Feature::payload_size), 1280U * 1024);
  EXPECT_EQ(desk.write(Feature::pixel_format, *gige::pixel_code("BayerRG12")), Status::success);
  EXPECT_EQ(desk.read(Feature::payload_size), 2U * 1280 * 1024);
  EXPECT_EQ(desk.write(Feature::pixel_format, *gige::pixel_code("Mono12")), Status::invalid_parameter);
  desk.write(Feature::height, 512);
  EXPECT_EQ(desk.read(Feature::payload_size), 1280U * 1024);
  desk.write(Feature::chunk_enable, 1, 2);
  EXPECT_EQ(desk.read(Feature::payload_size), 1280U * 1024);  // Chunk mode is off.
  desk.write(Feature::chunk_mode, 1);
  EXPECT_EQ(desk.read(Feature::payload_size), 1280U * 1024 + 8 + 16);
}

TEST_F(CameraFeatures, RealsOutOfRangeAreRefused) {
  EXPECT_EQ(desk.write_real(Feature::exposure_time, 14.0F), Status::invalid_parameter);
  EXPECT_EQ(desk.write_real(Feature::exposure_time, 15.0F), Status::success);
  EXPECT_EQ(desk.write_real(Feature::exposure_time, 1e7F), Status::success);
  EXPECT_EQ(desk.write_real(Feature::exposure_time, 1.1e7F), Status::invalid_parameter);
  EXPECT_EQ(desk.write_real(Feature::gain, std::nanf("")), Status::invalid_parameter);
  EXPECT_EQ(desk.write_real(Feature::frame_rate, 0.1F), Status::success);
  EXPECT_EQ(desk.write_real(Feature::gain, std::numeric_limits<float>::infinity()), Status::invalid_parameter);
}

TEST_F(CameraFeatures, WhatWouldChangeTheStreamIsLockedWhileItRuns) {
  desk.write(Feature::acquisition_start, 1);
  EXPECT_EQ(desk.read(Feature::locked), 1U);
  EXPECT_EQ(desk.write(Feature::width, 640), Status::write_protected);
  EXPECT_EQ(desk.write(Feature::chunk_mode, 1), Status::write_protected);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kStreamPacketSize, 576), Status::write_protected);
  EXPECT_EQ(desk.write_real(Feature::exposure_time, 2000.0F), Status::success);
  desk.write(Feature::acquisition_stop, 1);
  EXPECT_EQ(desk.read(Feature::locked), 0U);
  EXPECT_EQ(desk.write(Feature::width, 640), Status::success);
}

TEST_F(CameraFeatures, ItRunsAtItsRateAsFarAsTheLinkAllows) {
  EXPECT_NEAR(desk.read_real(Feature::resulting_frame_rate), 60.0, 0.01);
  desk.write(Feature::acquisition_start, 1);
  const auto frames = desk.wait(second_ns);
  EXPECT_NEAR(static_cast<double>(frames.size()), 60.0, 1.0);
  EXPECT_EQ(frames.front().block, 1);
  EXPECT_EQ(frames.back().block, frames.size());
  EXPECT_NEAR(static_cast<double>(frames[1].ticks - frames[0].ticks), 1e8 / 60, 2);
  desk.write(Feature::acquisition_stop, 1);
  desk.write(Feature::frame_rate_enable, 0);
  // 1280 x 1024 bytes in packets of 1500 over 1 Gbit/s.
  EXPECT_NEAR(desk.read_real(Feature::resulting_frame_rate), 90.8, 0.1);
  desk.write(desk.host, bootstrap::kStreamPacketDelay, 1000);  // 10 us a packet.
  EXPECT_NEAR(desk.read_real(Feature::resulting_frame_rate), 50.1, 0.1);
  desk.write_real(Feature::exposure_time, 50'000.0F);
  EXPECT_NEAR(desk.read_real(Feature::resulting_frame_rate), 20.0, 0.01);
}

TEST_F(CameraFeatures, TriggeredEachPulseIsOneFrame) {
  desk.write(Feature::trigger_mode, 1);
  desk.write_real(Feature::trigger_delay, 1000.0F);
  desk.write(Feature::acquisition_start, 1);
  EXPECT_TRUE(desk.wait(second_ns).empty());
  std::vector<FrameOrder> frames;
  for (int i = 0; i < 10; ++i) {
    desk.camera.pulse({0, desk.now_ns, desk.now_ns + 1'000'000, 100 + i});
    const std::int64_t rise = desk.now_ns;
    const auto some = desk.wait(second_ns / 20);
    ASSERT_EQ(some.size(), 1U);
    EXPECT_EQ(some[0].pulse, 100 + i);
    EXPECT_EQ(some[0].start_ns, rise + 1'000'000);
    frames.insert(frames.end(), some.begin(), some.end());
  }
  EXPECT_EQ(frames.back().number, 9U);
}

TEST_F(CameraFeatures, PulsesThatComeSoonerThanItsRateAllowsAreIgnored) {
  desk.write(Feature::trigger_mode, 1);
  desk.write_real(Feature::frame_rate, 20.0F);
  desk.write(Feature::acquisition_start, 1);
  const auto frames_of_pulses = [this] {
    // The second one comes early, by 2 ms.
    for (const std::int64_t after_ms : {1, 49, 101})
      desk.camera.pulse(
          {0, desk.now_ns + after_ms * 1'000'000, desk.now_ns + after_ms * 1'000'000 + 500'000, after_ms});
    return desk.wait(second_ns / 2).size();
  };
  EXPECT_EQ(frames_of_pulses(), 2U);
  EXPECT_EQ(desk.camera.ignored_triggers(), 1U);
  desk.write(Feature::frame_rate_enable, 0);
  EXPECT_EQ(frames_of_pulses(), 3U);
}

TEST_F(CameraFeatures, SingleAndMultiFrameEndByThemselves) {
  desk.write(Feature::acquisition_mode, static_cast<std::uint32_t>(AcquisitionMode::multi_frame));
  desk.write(Feature::acquisition_frame_count, 3);
  desk.write(Feature::acquisition_start, 1);
  EXPECT_EQ(desk.wait(second_ns).size(), 3U);
  EXPECT_EQ(desk.read(Feature::locked), 0U);
  desk.write(Feature::acquisition_mode, static_cast<std::uint32_t>(AcquisitionMode::single_frame));
  desk.write(Feature::acquisition_start, 1);
  EXPECT_EQ(desk.wait(second_ns).size(), 1U);
}

TEST_F(CameraFeatures, BlockIdsBeginAnewAndSkipZero) {
  VirtualCameraOptions options = desk_camera();
  options.first_block = 65530;
  CameraDesk other(options);
  other.take_control();
  other.open_stream();
  other.write(Feature::acquisition_start, 1);
  const auto frames = other.wait(second_ns / 2);
  ASSERT_GT(frames.size(), 10U);
  EXPECT_EQ(frames[5].block, 65535);
  EXPECT_EQ(frames[6].block, 1);
  EXPECT_EQ(frames[6].number, 6U);
  other.write(Feature::acquisition_start, 1);
  EXPECT_EQ(other.wait(second_ns / 10).front().block, 65530);
}

TEST_F(CameraFeatures, LinesAreInputsOrOutputsAsTheyAreBuilt) {
  const auto strobe = static_cast<std::uint32_t>(LineMode::strobe);
  EXPECT_EQ(desk.read(Feature::line_mode, 1), strobe);
  EXPECT_EQ(desk.write(Feature::line_mode, strobe, 0), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::line_mode, 0, 1), Status::invalid_parameter);
  EXPECT_EQ(desk.write(Feature::line_mode, strobe, 2), Status::success);
  EXPECT_EQ(desk.write(Feature::line_mode, 0, 3), Status::invalid_address);      // There is no line 3.
  EXPECT_EQ(desk.write(Feature::trigger_source, 1), Status::invalid_parameter);  // Line 1 is an output.
}

TEST_F(CameraFeatures, AStrobeShowsTheExposure) {
  desk.write(Feature::acquisition_mode, static_cast<std::uint32_t>(AcquisitionMode::single_frame));
  const auto frame = [this] {
    desk.write(Feature::acquisition_start, 1);
    return desk.wait(second_ns / 10).at(0);
  };
  EXPECT_FALSE(frame().strobe(1).has_value());
  desk.write(Feature::strobe_enable, 1, 0);  // Line 0 is an input.
  desk.write(Feature::strobe_enable, 1, 1);
  const FrameOrder whole = frame();
  EXPECT_FALSE(whole.strobe(0).has_value());
  EXPECT_FALSE(whole.strobe(7).has_value());
  ASSERT_TRUE(whole.strobe(1).has_value());
  EXPECT_EQ(whole.strobe(1)->rise_ns, whole.start_ns);
  EXPECT_EQ(whole.strobe(1)->fall_ns, whole.start_ns + 5'000'000);
  desk.write(Feature::strobe_delay, 20, 1);
  desk.write(Feature::strobe_duration, 300, 1);
  const FrameOrder part = frame();
  EXPECT_EQ(part.strobe(1)->rise_ns, part.start_ns + 20'000);
  EXPECT_EQ(part.strobe(1)->fall_ns, part.start_ns + 320'000);
}

TEST_F(CameraFeatures, UserSetsKeepSettingsOverAReset) {
  desk.write(Feature::user_set_selector, 0);
  EXPECT_EQ(desk.write(Feature::user_set_save, 1), Status::invalid_parameter);
  desk.write_real(Feature::exposure_time, 700.0F);
  desk.write(Feature::strobe_delay, 30, 2);
  desk.write(Feature::user_set_selector, 1);
  EXPECT_EQ(desk.write(Feature::user_set_save, 1), Status::success);
  desk.write(Feature::user_set_default, 1);
  desk.write_real(Feature::exposure_time, 900.0F);
  desk.write(Feature::user_set_load, 1);
  EXPECT_EQ(desk.read_real(Feature::exposure_time), 700.0F);
  desk.write(Feature::device_reset, 1);
  desk.wait(3 * second_ns);
  EXPECT_EQ(desk.read_real(Feature::exposure_time), 700.0F);
  EXPECT_EQ(desk.read(Feature::strobe_delay, 2), 30U);
  desk.take_control();
  desk.write(Feature::user_set_selector, 0);
  desk.write(Feature::user_set_load, 1);
  EXPECT_EQ(desk.read_real(Feature::exposure_time), 5000.0F);
}

TEST_F(CameraFeatures, ItsClockIsLatchedAndResetAndDrifts) {
  VirtualCameraOptions options = desk_camera();
  options.clock_start_ns = 100 * second_ns;
  options.clock_drift = 50e-6;
  CameraDesk other(options);
  other.take_control();
  other.now_ns += 1000'000'000;
  EXPECT_EQ(other.read(bootstrap::kTickFrequencyLow), 100'000'000U);
  other.write(other.host, bootstrap::kTimestampControl, gige::kTimestampLatch);
  const auto latched = [&other] {
    return std::uint64_t{other.read(bootstrap::kTimestampHigh)} << 32U | other.read(bootstrap::kTimestampLow);
  };
  EXPECT_EQ(latched(), 10'000'000'000U + 100'000'000 + 5'000);
  other.write(other.host, bootstrap::kTimestampControl, gige::kTimestampReset);
  other.now_ns += 1'000'000;
  EXPECT_EQ(latched(), 10'100'005'000U);  // As it was latched.
  other.write(other.host, bootstrap::kTimestampControl, gige::kTimestampLatch);
  EXPECT_NEAR(static_cast<double>(latched()), 100'005, 1);
}

TEST_F(CameraFeatures, ATestPacketIsFiredOnceAsLargeAsAsked) {
  desk.write(desk.host, bootstrap::kStreamPacketSize, gige::kFireTestPacket | gige::kDoNotFragment | 8000);
  ASSERT_TRUE(desk.out.test_packet.has_value());
  EXPECT_EQ(desk.out.test_packet->packet_bytes, 7996U);  // In steps of 8 from 220.
  EXPECT_TRUE(desk.out.test_packet->do_not_fragment);
  EXPECT_EQ(desk.out.test_packet->to, (Endpoint{{192, 168, 1, 5}, 50500}));
  EXPECT_EQ(desk.read(bootstrap::kStreamPacketSize), gige::kDoNotFragment | 7996);
  EXPECT_FALSE(desk.out.test_packet.has_value());
  EXPECT_EQ(desk.write(desk.host, bootstrap::kStreamPacketSize, 200), Status::invalid_parameter);
  EXPECT_EQ(desk.write(desk.host, bootstrap::kStreamPacketSize, 10'000), Status::invalid_parameter);
}

TEST_F(CameraFeatures, TheAutomaticExposureSettles) {
  desk.write(Feature::exposure_auto, static_cast<std::uint32_t>(ExposureAuto::once));
  const auto bright = [this] {
    return std::min(1.0, static_cast<double>(desk.read_real(Feature::exposure_time)) / 40'000);
  };
  for (int i = 0; i < 10; ++i) desk.camera.meter(desk.now_ns, bright());
  EXPECT_NEAR(bright(), 0.45, 0.03);
  EXPECT_EQ(desk.read(Feature::exposure_auto), 0U);
  desk.write(Feature::exposure_auto, static_cast<std::uint32_t>(ExposureAuto::continuous));
  for (int i = 0; i < 30; ++i) desk.camera.meter(desk.now_ns, 1.0);
  EXPECT_EQ(desk.read_real(Feature::exposure_time), 15.0F);
  EXPECT_EQ(desk.read(Feature::exposure_auto), 2U);
}

TEST(BrightnessOfCameras, IsTheMeanOfTheValues) {
  std::vector<std::uint8_t> image(100'000, 255);
  EXPECT_DOUBLE_EQ(mean_brightness(image, *gige::pixel_code("BayerRG8")), 1.0);
  for (std::size_t i = 0; i < image.size(); ++i) image[i] = i % 2 == 0 ? 0xFF : 0x07;
  EXPECT_DOUBLE_EQ(mean_brightness(image, *gige::pixel_code("Mono12")), 0x7FF / 4095.0);
  EXPECT_EQ(mean_brightness({}, *gige::pixel_code("Mono12")), 0.0);
}

}  // namespace
}  // namespace rigcal::sim
