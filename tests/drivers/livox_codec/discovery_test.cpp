#include "drivers/livox_codec/discovery.h"

#include <gtest/gtest.h>

#include "core/records/records.h"
#include "tests/support/hex.h"

namespace rigcal::livox {
namespace {

struct BroadcastExample {
  std::string hex;
  std::uint16_t seq;
  Broadcast broadcast;
};

TEST(Broadcast, ReadsAndWritesEveryWorkedExampleToTheByte) {
  const std::vector<BroadcastExample> examples{
      {"aa012200020000597e0000334a45444b3338303031305a333931000700009dbd7ad7",
       0,
       {"3JEDK380010Z391", DeviceType::avia, 0}},
      {"aa0122000201008167 0000334a45444b3338303031305a3339310007e8fd6d3c532f",
       1,
       {"3JEDK380010Z391", DeviceType::avia, 65000}},
      {"aa012200020000597e0000305446444647373030363031383831000100003fe90e9a",
       0,
       {"0TFDFG700601881", DeviceType::mid40, 0}},
      {"aa012200020000597e000030544644464737303036303138383200010000ef93aedd",
       0,
       {"0TFDFG700601882", DeviceType::mid40, 0}},
      {"aa012200020000597e0000305446444647373030363031383833000100005fbacee0",
       0,
       {"0TFDFG700601883", DeviceType::mid40, 0}},
      {"aa012200024800fff60000315051444c3548303031554c3939310002e8fdc51185fc",
       72,
       {"1PQDL5H001UL991", DeviceType::tele15, 65000}},
  };
  for (const BroadcastExample& example : examples) {
    const auto bytes = from_hex(example.hex);
    const Expected<ControlFrame> frame = parse_control_frame(bytes);
    ASSERT_TRUE(frame) << frame.error().message();
    EXPECT_EQ(frame->seq, example.seq);
    const Expected<Broadcast> broadcast = parse_broadcast(*frame);
    ASSERT_TRUE(broadcast) << broadcast.error().message();
    EXPECT_EQ(broadcast->broadcast_code, example.broadcast.broadcast_code);
    EXPECT_EQ(broadcast->type, example.broadcast.type);
    EXPECT_EQ(broadcast->command_port, example.broadcast.command_port);
    EXPECT_EQ(make_broadcast(*broadcast, frame->seq), bytes);
  }
}

TEST(Broadcast, RefusesAWrongLengthTypeOrCode) {
  std::vector<std::uint8_t> payload = from_hex("334a45444b3338303031305a33393100070000");
  ControlFrame frame{FrameType::message, 0, CommandSet::general, 0, payload};
  ASSERT_TRUE(parse_broadcast(frame));
  frame.payload = ByteView(payload).first(18);
  EXPECT_FALSE(parse_broadcast(frame));
  frame.payload = payload;
  payload[16] = 4;  // No such device.
  EXPECT_FALSE(parse_broadcast(frame));
  payload[16] = 7;
  payload[3] = 0x1B;  // An escape character must not reach a terminal.
  EXPECT_FALSE(parse_broadcast(frame));
  payload[3] = 'D';
  payload[15] = 'x';  // The closing NUL.
  EXPECT_FALSE(parse_broadcast(frame));
  payload[15] = 0;
  frame.id = 7;
  EXPECT_FALSE(parse_broadcast(frame));
}

TEST(Handshake, ReadsAndWritesEveryWorkedExampleToTheByte) {
  const std::vector<std::string> examples{
      "aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0",
      "aa0119000002006c6b0001c0a80105c1dacdd8c1dab272ff8a",
      "aa01170000000064390001c0a82101bd07e8fd1e25f912",
  };
  for (const std::string& hex : examples) {
    const auto bytes = from_hex(hex);
    const Expected<ControlFrame> frame = parse_control_frame(bytes);
    ASSERT_TRUE(frame);
    const Expected<Handshake> handshake = parse_handshake(*frame);
    ASSERT_TRUE(handshake) << handshake.error().message();
    EXPECT_EQ(make_handshake(*handshake, frame->seq, frame->type), bytes) << hex;
  }
}

TEST(Handshake, GivesHostAndPortsOfTheNewAndTheOldForm) {
  const auto bytes = from_hex("aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0");
  const Expected<Handshake> handshake = parse_handshake(*parse_control_frame(bytes));
  ASSERT_TRUE(handshake);
  EXPECT_EQ(to_string(handshake->host_ip), "192.168.1.5");
  EXPECT_EQ(handshake->data_port, 56001);
  EXPECT_EQ(handshake->command_port, 55501);
  EXPECT_EQ(handshake->imu_port, 56001);
  const auto old_bytes = from_hex("aa01170000000064390001c0a82101bd07e8fd1e25f912");
  const Expected<Handshake> old_form = parse_handshake(*parse_control_frame(old_bytes));
  ASSERT_TRUE(old_form);
  EXPECT_EQ(to_string(old_form->host_ip), "192.168.33.1");
  EXPECT_EQ(old_form->data_port, 1981);
  EXPECT_EQ(old_form->command_port, 65000);
  EXPECT_FALSE(old_form->imu_port.has_value());
}

TEST(Handshake, IsNotTheAnswerToOne) {
  const auto bytes = from_hex("aa011000010200d460000100837afa4c");
  const Expected<ControlFrame> frame = parse_control_frame(bytes);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(is_handshake(*frame));
  EXPECT_FALSE(parse_handshake(*frame));
}

TEST(DeviceTypes, AreTheCodesOfTheModels) {
  EXPECT_EQ(DeviceType::avia, device_type(LidarModel::livox_avia));
  EXPECT_EQ(DeviceType::mid40, device_type(LidarModel::livox_mid40));
  EXPECT_EQ(DeviceType::mid70, device_type(LidarModel::livox_mid70));
  EXPECT_EQ(DeviceType::horizon, device_type(LidarModel::livox_horizon));
  EXPECT_EQ(DeviceType::tele15, device_type(LidarModel::livox_tele15));
  EXPECT_EQ(std::nullopt, device_type(LidarModel::other));
  for (const LidarFacts& row : lidar_models()) {
    if (const auto type = device_type(row.model)) {
      EXPECT_EQ(row.model, lidar_model(*type)) << row.word;
    }
  }
  EXPECT_EQ(LidarModel::other, lidar_model(DeviceType::hub));
  EXPECT_EQ("Hub", model_name(DeviceType::hub));
  EXPECT_EQ("device type 4", model_name(static_cast<DeviceType>(4)));
}

}  // namespace
}  // namespace rigcal::livox
