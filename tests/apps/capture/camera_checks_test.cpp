#include "apps/capture/camera_checks.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace rigcal {
namespace {

using testing::ElementsAre;
using testing::Field;
using testing::HasSubstr;
using testing::SizeIs;

CameraFinding good_camera() {
  CameraFinding finding;
  finding.sensor = "camera_left";
  finding.identity = {"Hikrobot-MV-CA013-00F1", "192.168.1.40", "00F1", "Hikrobot", "MV-CA013", "GigE Vision"};
  finding.setup.pixel_format = "BayerRG8";
  finding.setup.width = 1280;
  finding.setup.height = 1024;
  finding.setup.packet_bytes = 1500;
  finding.counters.frames[0] = 5;
  return finding;
}

const std::vector<net::Interface> eth0{{"eth0", 2, {192, 168, 1, 5}, {255, 255, 255, 0}, true, false, 1500}};

TEST(CameraChecks, ACameraThatSendsIsGood) {
  const auto checks = check_cameras({good_camera()}, {good_camera().identity}, eth0);
  ASSERT_THAT(checks, SizeIs(1));
  EXPECT_EQ(checks[0].level, CheckLevel::good);
  EXPECT_THAT(checks[0].what, HasSubstr("MV-CA013 at 192.168.1.40, GigE Vision, BayerRG8 1280 x 1024"));
}

TEST(CameraChecks, TroubleIsToldWithItsMend) {
  CameraFinding absent;
  absent.sensor = "camera_left";
  absent.trouble = system_error("there is no such camera", "camera_left (00F2)", "there is Hikrobot-MV-CA013-00F1");
  const auto checks = check_cameras({absent}, {good_camera().identity}, eth0);
  ASSERT_THAT(checks, SizeIs(2));
  EXPECT_EQ(checks[0].level, CheckLevel::bad);
  EXPECT_THAT(checks[0].mend, HasSubstr("00F1"));
  EXPECT_EQ(checks[1].about, "camera");
  EXPECT_THAT(checks[1].what, HasSubstr("is there, GigE Vision at 192.168.1.40"));
}

TEST(CameraChecks, PacketsHaveToFitTheNetwork) {
  CameraFinding finding = good_camera();
  finding.setup.packet_bytes = 9000;
  const auto checks = check_cameras({finding}, {}, eth0);
  EXPECT_EQ(worst_of(checks), CheckLevel::bad);
  EXPECT_THAT(checks, Contains(Field(&Check::mend, HasSubstr("sudo ip link set eth0 mtu 9000"))));
}

TEST(CameraChecks, FramesThatDoNotComeAreAFault) {
  CameraFinding silent = good_camera();
  silent.counters.frames[0] = 0;
  EXPECT_EQ(worst_of(check_cameras({silent}, {}, eth0)), CheckLevel::bad);
  silent.trigger = "Line0";
  const auto waits = check_cameras({silent}, {}, eth0);
  EXPECT_EQ(worst_of(waits), CheckLevel::good);
  EXPECT_THAT(waits[0].what, HasSubstr("waits for pulses on Line0"));
  CameraFinding torn = good_camera();
  torn.counters.frames[1] = 2;
  torn.counters.missing = 3;
  const auto checks = check_cameras({torn}, {}, eth0);
  EXPECT_EQ(worst_of(checks), CheckLevel::warning);
  EXPECT_THAT(checks.back().what, HasSubstr("2 frames were damaged and 3 missing"));
}

TEST(CameraChecks, WhatIsOtherwiseThanWantedIsAWarning) {
  CameraFinding finding = good_camera();
  finding.setup.notes = {"it sends 640 x 480 pixels, and its intrinsics are for 1280 x 1024"};
  EXPECT_EQ(worst_of(check_cameras({finding}, {}, eth0)), CheckLevel::warning);
}

}  // namespace
}  // namespace rigcal
