#include "drivers/livox/protocol/abilities.h"

#include <gtest/gtest.h>

#include <string>

namespace rigcal::livox {
namespace {

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

}  // namespace
}  // namespace rigcal::livox
