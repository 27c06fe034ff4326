#include "drivers/trigger/pps.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/trigger/trigger.h"

namespace rigcal::trigger {
namespace {

TEST(Pps, DeviceThatIsNotThereIsSaidInWords) {
  const auto device = PpsDevice::open("pps_that_is_not");
  ASSERT_FALSE(device.has_value());
  EXPECT_EQ(device.error().kind, ErrorKind::system);
  EXPECT_THAT(device.error().message(), testing::HasSubstr("/dev/pps_that_is_not: there is no such PPS device"));
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
