#include "drivers/livox_codec/status.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal::livox {
namespace {

TEST(Status, ReadsTheWordOfARealTele15) {
  Status expected;
  expected.dirty = 1;
  expected.fan_warning = true;
  expected.ptp_ok = true;
  expected.time_sync = TimeSync::ptp;
  expected.system = Level::warning;
  EXPECT_EQ(decode_status(0x40006840U), expected);
  EXPECT_EQ(encode_status(expected), 0x40006840U);
}

TEST(Status, ReadsGpsAndPpsWords) {
  const Status gps = decode_status(0x00008200U);
  EXPECT_TRUE(gps.pps_ok);
  EXPECT_EQ(gps.time_sync, TimeSync::gps);
  EXPECT_EQ(decode_status(0x0000C200U).time_sync, TimeSync::pps);
}

TEST(Status, PutsEachFieldIntoItsOwnBits) {
  EXPECT_EQ(encode_status({.temperature = Level::error}), 0x2U);
  EXPECT_EQ(encode_status({.voltage = Level::error}), 0x8U);
  EXPECT_EQ(encode_status({.motor = Level::error}), 0x20U);
  EXPECT_EQ(encode_status({.dirty = 1}), 0x40U);
  EXPECT_EQ(encode_status({.firmware_abnormal = true}), 0x100U);
  EXPECT_EQ(encode_status({.pps_ok = true}), 0x200U);
  EXPECT_EQ(encode_status({.near_end_of_life = true}), 0x400U);
  EXPECT_EQ(encode_status({.fan_warning = true}), 0x800U);
  EXPECT_EQ(encode_status({.self_heating_bit = true}), 0x1000U);
  EXPECT_EQ(encode_status({.ptp_ok = true}), 0x2000U);
  EXPECT_EQ(encode_status({.time_sync = TimeSync::abnormal}), 0x10000U);
  EXPECT_EQ(encode_status({.system = Level::error}), 0x80000000U);
}

TEST(Status, EveryWordComesBackFromARoundTrip) {
  Random random(3);
  for (int i = 0; i < 10000; ++i) {
    const auto word = static_cast<std::uint32_t>(random.next_u64());
    EXPECT_EQ(encode_status(decode_status(word)), word);
  }
}

TEST(HubStatus, PutsEachFieldIntoItsOwnBits) {
  EXPECT_EQ(encode_hub_status({.time_sync = 2}), 0x2U);
  EXPECT_EQ(encode_hub_status({.temperature = Level::error}), 0x8U);
  EXPECT_EQ(encode_hub_status({.lidar_abnormal = true}), 0x10U);
  EXPECT_EQ(encode_hub_status({.lidar_link_changed = true}), 0x20U);
  EXPECT_EQ(encode_hub_status({.lidar_firmware_abnormal = true}), 0x40U);
  EXPECT_EQ(encode_hub_status({.system = Level::warning}), 0x40000000U);
}

TEST(Status, SaysWhatTheClockFollows) {
  Status status;
  EXPECT_EQ(sync_text(status), "not synchronised");
  status.pps_ok = true;
  EXPECT_EQ(sync_text(status), "not synchronised, although it has pulses (PPS)");
  status.ptp_ok = true;
  EXPECT_EQ(sync_text(status), "not synchronised, although it hears a PTP master");
  status.time_sync = TimeSync::ptp;
  EXPECT_EQ(sync_text(status), "synchronised by PTP");
  status.time_sync = TimeSync::gps;
  EXPECT_NE(sync_text(status).find("GPS"), std::string::npos);
  status.time_sync = TimeSync::pps;
  EXPECT_NE(sync_text(status).find("without the time of day"), std::string::npos);
  status.time_sync = TimeSync::abnormal;
  EXPECT_EQ(sync_text(status), "its synchronisation has failed");
}

TEST(HubStatus, EveryWordComesBackFromARoundTrip) {
  Random random(4);
  for (int i = 0; i < 10000; ++i) {
    const auto word = static_cast<std::uint32_t>(random.next_u64());
    EXPECT_EQ(encode_hub_status(decode_hub_status(word)), word);
  }
}

TEST(Tag, EveryByteComesBackFromARoundTrip) {
  for (unsigned byte = 0; byte < 256; ++byte) {
    EXPECT_EQ(encode_tag(decode_tag(static_cast<std::uint8_t>(byte))), byte);
  }
}

TEST(Tag, HighAndModerateConfidenceIsNoise) {
  EXPECT_FALSE(is_noise(decode_tag(0x10)));  // A normal first echo.
  EXPECT_TRUE(is_noise(decode_tag(0x01)));
  EXPECT_TRUE(is_noise(decode_tag(0x02)));
  EXPECT_FALSE(is_noise(decode_tag(0x03)));
  EXPECT_TRUE(is_noise(decode_tag(0x04)));
  EXPECT_TRUE(is_noise(decode_tag(0x08)));
  EXPECT_FALSE(is_noise(decode_tag(0x0C)));
}

}  // namespace
}  // namespace rigcal::livox
