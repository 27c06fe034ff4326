#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "drivers/gige_codec/bootstrap.h"

namespace rigcal::gige {
namespace {

DeviceIdentity camera() {
  DeviceIdentity identity;
  identity.mac = {0x34, 0xBD, 0x20, 0x01, 0x02, 0x03};
  identity.ip = {192, 168, 1, 31};
  identity.mask = {255, 255, 255, 0};
  identity.gateway = {192, 168, 1, 1};
  identity.manufacturer = "Hikrobot";
  identity.model = "MV-CA013-21UC";
  identity.device_version = "V1.0";
  identity.information = "simulated";
  identity.serial = "00F12345678";
  identity.user_name = "left";
  return identity;
}

TEST(GigeIdentity, HasItsFieldsWhereTheStandardHasThem) {
  const auto bytes = encode_identity(camera());
  ASSERT_EQ(bytes.size(), 0xF8U);
  const auto text = [&bytes](std::size_t at) { return std::string(reinterpret_cast<const char*>(bytes.data() + at)); };
  EXPECT_EQ(bytes[1], 1);  // Version 1.2.
  EXPECT_EQ(bytes[3], 2);
  EXPECT_EQ(bytes[4], 0x80);  // Big-endian.
  EXPECT_EQ(bytes[0x0A], 0x34);
  EXPECT_EQ(bytes[0x0F], 0x03);
  EXPECT_EQ(bytes[0x27], 31);
  EXPECT_EQ(bytes[0x36], 255);
  EXPECT_EQ(bytes[0x47], 1);
  EXPECT_EQ(text(0x48), "Hikrobot");
  EXPECT_EQ(text(0x68), "MV-CA013-21UC");
  EXPECT_EQ(text(0x88), "V1.0");
  EXPECT_EQ(text(0xA8), "simulated");
  EXPECT_EQ(text(0xD8), "00F12345678");
  EXPECT_EQ(text(0xE8), "left");
}

TEST(GigeIdentity, ReadsBackAsWritten) { EXPECT_EQ(*decode_identity(encode_identity(camera())), camera()); }

TEST(GigeIdentity, TextsEndWithTheirFields) {
  DeviceIdentity identity = camera();
  identity.serial = "0123456789ABCDEFGH";
  auto bytes = encode_identity(identity);
  EXPECT_EQ(decode_identity(bytes)->serial, "0123456789ABCDE");
  bytes[0xE7] = 'x';  // A device that leaves the NUL away.
  EXPECT_EQ(decode_identity(bytes)->serial, "0123456789ABCDEx");
}

TEST(GigeIdentity, CutShortIsRefused) {
  const auto bytes = encode_identity(camera());
  for (const std::size_t size : {std::size_t{0}, std::size_t{100}, bytes.size() - 1})
    EXPECT_FALSE(decode_identity(ByteView(bytes).first(size)).has_value());
}

}  // namespace
}  // namespace rigcal::gige
