#include "drivers/trigger/pps.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "drivers/trigger/trigger.h"
#include "tests/support/scratch_folder.h"

namespace rigcal::trigger {
namespace {

TEST(Pps, DeviceThatIsNotThereIsSaidInWords) {
  const auto device = PpsDevice::open("pps_that_is_not");
  ASSERT_FALSE(device.has_value());
  EXPECT_EQ(device.error().kind, ErrorKind::system);
  EXPECT_THAT(device.error().message(), testing::HasSubstr("/dev/pps_that_is_not: there is no such PPS device"));
}

TEST(PpsCount, AnswersAtFallingEdgesAreNoPulses) {
  PpsCount count(41);
  EXPECT_EQ(count.missed_before(41), std::nullopt) << "rose before it was listened to";
  EXPECT_EQ(count.missed_before(42), 0U);
  EXPECT_EQ(count.missed_before(42), std::nullopt);
  EXPECT_EQ(count.missed_before(43), 0U);
  EXPECT_EQ(count.missed_before(43), std::nullopt);
}

TEST(PpsCount, MissedPulsesAreThoseBetweenTwoThatWereSeen) {
  PpsCount count(41);
  EXPECT_EQ(count.missed_before(45), 0U) << "nobody waited for those before the first";
  EXPECT_EQ(count.missed_before(48), 2U);
  EXPECT_EQ(count.missed_before(49), 0U);
}

TEST(PpsCount, ASourceThatCountsAnewHasMissedNothing) {
  PpsCount count(1000);
  EXPECT_EQ(count.missed_before(1001), 0U);
  EXPECT_EQ(count.missed_before(1), 0U);
  EXPECT_EQ(count.missed_before(3), 1U);
  PpsCount wraps(0xFFFF'FFFE);
  EXPECT_EQ(wraps.missed_before(0xFFFF'FFFF), 0U);
  EXPECT_EQ(wraps.missed_before(0), 0U);
  EXPECT_EQ(wraps.missed_before(2), 1U);
}

TEST(Pps, AFileThatWasRemovedOrMadeAnewIsNoLongerThere) {
  const std::filesystem::path folder = scratch_folder("pps");
  const std::string path = (folder / "pps0").string();
  std::ofstream(path) << "first";
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  ASSERT_GE(descriptor, 0);
  EXPECT_TRUE(is_still_there(descriptor, path));
  std::filesystem::remove(path);
  EXPECT_FALSE(is_still_there(descriptor, path));
  std::ofstream(path) << "second";
  EXPECT_FALSE(is_still_there(descriptor, path));
  close(descriptor);
}

TEST(Pps, ADeviceThatIsTakenAwayIsNoticedAndTakenAgain) {
  if (std::getenv("RIGCAL_IN_GUEST") == nullptr)
    GTEST_SKIP() << "SKIP: it takes a driver away, in the virtual machine of tests/hil/run only";
  TriggerOptions options;
  options.pps = "pps0";
  const auto trigger = Trigger::start(options, net::read_clocks());
  ASSERT_TRUE(trigger.has_value()) << trigger.error().message();
  TriggerEvent event;
  const auto wait_for = [&](TriggerEventKind kind) {
    for (int i = 0; i < 10; ++i) {
      if ((*trigger)->next(event, 5'000'000'000) && event.kind == kind) return true;
    }
    return false;
  };
  EXPECT_TRUE(wait_for(TriggerEventKind::pulse));
  ASSERT_EQ(std::system("rmmod pps-ktimer"), 0);
  EXPECT_TRUE(wait_for(TriggerEventKind::lost));
  ASSERT_EQ(std::system("modprobe pps-ktimer"), 0);
  EXPECT_TRUE(wait_for(TriggerEventKind::returned));
  EXPECT_TRUE(wait_for(TriggerEventKind::pulse));
  (*trigger)->stop();
  EXPECT_EQ((*trigger)->report().losses, 1U);
  EXPECT_EQ((*trigger)->report().pps_lost, 0U);
}

TEST(Pps, PulsesComeOnceASecond) {
  if (list_pps().empty()) GTEST_SKIP() << "SKIP: this kernel has no PPS device; tests/hil/run has one";
  TriggerOptions options;
  options.pps = list_pps().front();
  const auto trigger = Trigger::start(options, net::read_clocks());
  ASSERT_TRUE(trigger.has_value()) << trigger.error().message();
  std::int64_t last_stamp = 0;
  std::int64_t last_number = 0;
  for (int i = 0; i < 4; ++i) {
    TriggerEvent event;
    ASSERT_TRUE((*trigger)->next(event, 5'000'000'000));
    EXPECT_EQ(event.source, TriggerSource::pps);
    if (i > 0) {
      EXPECT_EQ(event.number, last_number + 1);
      EXPECT_NEAR(static_cast<double>(event.stamp_ns - last_stamp), 1e9, 0.1e9);  // A timer in a busy virtual machine.
    }
    last_stamp = event.stamp_ns;
    last_number = event.number;
  }
  (*trigger)->stop();
  EXPECT_EQ((*trigger)->report().pps_pulses, 4U);
  EXPECT_EQ((*trigger)->report().pps_lost, 0U);
}

}  // namespace
}  // namespace rigcal::trigger
