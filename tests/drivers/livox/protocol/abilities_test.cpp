#include "drivers/livox/protocol/abilities.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace rigcal::livox {
namespace {

using testing::HasSubstr;

constexpr FirmwareVersion newest{99, 0, 0, 0};

TEST(Abilities, FollowModelAndFirmware) {
  EXPECT_TRUE(can_do(DeviceType::avia, newest, SetReturnModeRequest{Echoes::triple}));
  EXPECT_FALSE(can_do(DeviceType::horizon, newest, SetReturnModeRequest{Echoes::triple}));
  EXPECT_TRUE(can_do(DeviceType::horizon, newest, SetReturnModeRequest{Echoes::dual}));
  EXPECT_FALSE(can_do(DeviceType::mid40, newest, SetReturnModeRequest{Echoes::first}));
  EXPECT_FALSE(can_do(DeviceType::avia, {11, 5, 0, 0}, RebootRequest{}));
  EXPECT_TRUE(can_do(DeviceType::avia, {11, 6, 0, 0}, RebootRequest{}));
  EXPECT_TRUE(can_do(DeviceType::avia, {12, 0, 0, 0}, RebootRequest{}));
  EXPECT_FALSE(can_do(DeviceType::mid40, {3, 6, 9, 9}, SetUtcTimeRequest{}));
  EXPECT_TRUE(can_do(DeviceType::tele15, {1, 0, 0, 0}, SetUtcTimeRequest{}));
  EXPECT_TRUE(can_do(DeviceType::mid40, {1, 0, 0, 0}, RainSuppressionRequest{}));
  EXPECT_FALSE(can_do(DeviceType::avia, newest, RainSuppressionRequest{}));
  EXPECT_FALSE(can_do(DeviceType::mid70, newest, SetImuRateRequest{}));
  EXPECT_TRUE(can_do(DeviceType::mid40, {}, CoordinatesRequest{}));
}

TEST(Abilities, FollowTheKeysOfParameters) {
  const auto write = [](ParameterKey key) { return WriteParametersRequest{{{static_cast<std::uint16_t>(key), {1}}}}; };
  EXPECT_TRUE(can_do(DeviceType::avia, newest, write(ParameterKey::scan_pattern)));
  EXPECT_FALSE(can_do(DeviceType::tele15, newest, write(ParameterKey::scan_pattern)));
  EXPECT_TRUE(can_do(DeviceType::tele15, newest, write(ParameterKey::high_sensitivity)));
  EXPECT_FALSE(can_do(DeviceType::tele15, {7, 8, 0, 0}, write(ParameterKey::high_sensitivity)));
  EXPECT_TRUE(can_do(DeviceType::mid70, newest, write(ParameterKey::slot_number)));
  EXPECT_FALSE(can_do(DeviceType::mid40, newest, ReadParametersRequest{{1}}));
  EXPECT_FALSE(can_do(DeviceType::avia, newest, write(static_cast<ParameterKey>(77))));
}

TEST(FixedAddress, HasTheFormAndTheShareOfTheModel) {
  const Broadcast avia{"3JEDK380010Z391", DeviceType::avia, 0};
  const auto any = fixed_ip_request(avia, {10, 0, 0, 7});
  ASSERT_TRUE(any.has_value());
  EXPECT_TRUE(any->subnet.has_value());
  const Broadcast middle{"0TFDG3B00600552", DeviceType::mid40, 0};
  const auto own = fixed_ip_request(middle, {192, 168, 1, 91});
  ASSERT_TRUE(own.has_value());
  EXPECT_FALSE(own->subnet.has_value());
  EXPECT_THAT(fixed_ip_request(middle, {192, 168, 1, 80}).error().mend, HasSubstr("192.168.1.81 to 192.168.1.150"));
  EXPECT_FALSE(fixed_ip_request(middle, {10, 0, 0, 91}).has_value());
  EXPECT_FALSE(fixed_ip_request(avia, {192, 168, 1, 255}).has_value());
  EXPECT_FALSE(fixed_ip_request(avia, {224, 0, 0, 1}).has_value());
}

}  // namespace
}  // namespace rigcal::livox
