#pragma once

#include <string>
#include <vector>

#include "drivers/livox_codec/control_payload.h"

namespace rigcal::livox {

/// A control frame and what it says.
struct WorkedExample {
  std::string hex;
  ControlPayload payload;
};

/// Every control frame among the protocol's worked examples and frames of real devices.
inline const std::vector<WorkedExample>& worked_examples() {
  constexpr ReturnCode success = ReturnCode::success;
  constexpr StoredExtrinsics mounting{1.5F, -2.25F, 90.0F, 100, -200, 300};
  constexpr Ipv4 mask{255, 255, 255, 0};
  constexpr Ipv4 gateway{192, 168, 1, 1};
  constexpr std::int64_t utc_2020_09_10_17_15 = 1'599'758'100'000'000'000;
  static const std::vector<WorkedExample> examples{
      // Real devices.
      {"aa01170000000064390001c0a82101bd07e8fd1e25f912", Handshake{{192, 168, 33, 1}, 1981, 65000, {}}},
      {"aa0110000100006453000100f1343c29", HandshakeAck{success}},
      {"aa010f0000000004d7000338ba8d0c", HeartbeatRequest{}},
      {"aa012200024800fff60000315051444c3548303031554c3939310002e8fdc51185fc",
       Broadcast{"1PQDL5H001UL991", DeviceType::tele15, 65000}},
      // Set 0.
      {"aa012200020000597e0000334a45444b3338303031305a333931000700009dbd7ad7",
       Broadcast{"3JEDK380010Z391", DeviceType::avia, 0}},
      {"aa01220002010081670000334a45444b3338303031305a3339310007e8fd6d3c532f",
       Broadcast{"3JEDK380010Z391", DeviceType::avia, 65000}},
      {"aa012200020000597e0000305446444647373030363031383831000100003fe90e9a",
       Broadcast{"0TFDFG700601881", DeviceType::mid40, 0}},
      {"aa012200020000597e000030544644464737303036303138383200010000ef93aedd",
       Broadcast{"0TFDFG700601882", DeviceType::mid40, 0}},
      {"aa012200020000597e0000305446444647373030363031383833000100005fbacee0",
       Broadcast{"0TFDFG700601883", DeviceType::mid40, 0}},
      {"aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0",
       Handshake{{192, 168, 1, 5}, 56001, 55501, std::uint16_t{56001}}},  // As the vendor's software sends it: an ack.
      {"aa0119000002006c6b0001c0a80105c1dacdd8c1dab272ff8a",
       Handshake{{192, 168, 1, 5}, 56001, 55501, std::uint16_t{56001}}},
      {"aa011000010200d460000100837afa4c", HandshakeAck{success}},
      {"aa010f000003006cfd0002dae45636", DeviceInformationRequest{}},
      {"aa0114000103001c540002000b090000ef4d0992", DeviceInformationAck{success, {11, 9, 0, 0}}},
      {"aa010f0000040064b0000388d2a2e1", HeartbeatRequest{}},
      {"aa0116000104009c0f0003000100000000006a78b53c", HeartbeatAck{success, WorkState::normal, 0, 0}},
      {"aa0116000104009c0f0003000000280000001e2c6f92", HeartbeatAck{success, WorkState::initialising, 0, 40}},
      {"aa0116000104009c0f0003000100406800405ffbb997", HeartbeatAck{success, WorkState::normal, 0, 0x40006840}},
      {"aa0110000005000077000401ff363cfe", SamplingRequest{Sampling::start}},
      {"aa011000010500dc2d000400697b24ad", SamplingAck{success}},
      {"aa011000000600685d000400226f1ede", SamplingRequest{Sampling::stop}},
      {"aa0110000005000077000501be0727e7", CoordinatesRequest{Coordinates::spherical}},
      {"aa011000000600685d000500635e05c7", CoordinatesRequest{Coordinates::cartesian}},
      {"aa011000010600b40700050063231ae3", CoordinatesAck{success}},
      {"aa010f00000d007c6700060a2bacab", DisconnectRequest{}},
      {"aa011000010d001ce300060062267ad3", DisconnectAck{success}},
      {"aa011300020900d476000740680040a0d80068", AbnormalStatus{0x40006840}},
      {"aa011c00001800d925000801c0a8014dffffff00c0a801012895c4d0",
       SetIpModeRequest{IpMode::fixed, {192, 168, 1, 77}, Subnet{mask, gateway}}},
      {"aa011400001800f97f000801c0a8014d41a0bda4", SetIpModeRequest{IpMode::fixed, {192, 168, 1, 77}, {}}},
      {"aa0110000118003508000800c933b0b5", SetIpModeAck{success}},
      {"aa010f00000d007c6700099b36133b", GetIpModeRequest{}},
      {"aa011d00010d00689f00090001c0a80165ffffff00c0a801017cb63762",
       GetIpModeAck{success, IpMode::fixed, {192, 168, 1, 101}, Subnet{mask, gateway}}},
      {"aa011500010d0048c500090001c0a801650924a46f", GetIpModeAck{success, IpMode::fixed, {192, 168, 1, 101}, {}}},
      {"aa011100001a001d6a000a0004555a3ba8", RebootRequest{1024}},
      {"aa011000011a00853b000a00391f40e2", RebootAck{success}},
      {"aa01140000100039b1000b020001000124ab34ce", WriteParametersRequest{{{2, {1}}}}},
      {"aa01130001100039db000b00000000a9f80c7a", WriteParametersAck{success, 0, ParameterError::none}},
      {"aa01130001100039db000b01020001347b33b6",
       WriteParametersAck{ReturnCode::failure, 2, ParameterError::key_not_supported}},
      {"aa0112000011007993000c010200cb8ff703", ReadParametersRequest{{2}}},
      {"aa0118000111000d85000c0000000002000100013fe8729c",
       ReadParametersAck{success, 0, ParameterError::none, {{2, {1}}}}},
      {"aa01130000140085e6000d00000000c975c475", ResetParametersRequest::all()},
      {"aa011500001500c5c4000d010201000200b53e7acb", ResetParametersRequest{ParameterReset::listed, {1, 2}, {}}},
      {"aa01130001140059bc000d00000000a37f5d62", ResetParametersAck{success, 0, ParameterError::none}},
      // Set 1.
      {"aa011000001900314b010002e3e85984", SetPowerModeRequest{PowerMode::power_saving}},
      {"aa011000011900ed11010000cff4484e", SetPowerModeAck{success}},
      {"aa011000011900ed11010002e39546a0", SetPowerModeAck{ReturnCode::switching}},
      {"aa012700000700bda001010000c03f000010c00000b4426400000038ffffff2c010000c2f9222a",
       WriteExtrinsicsRequest{mounting}},
      {"aa0110000107006c1e01010069ab57b4", WriteExtrinsicsAck{success}},
      {"aa010f00000800c4190102ce6cbe63", ReadExtrinsicsRequest{}},
      {"aa01280001080055130102000000c03f000010c00000b4426400000038ffffff2c010000a0b9771c",
       ReadExtrinsicsAck{success, mounting}},
      {"aa01100000080078c70103015b4eb805", RainSuppressionRequest{Switch::on}},
      {"aa0110000109007c84010300f4244364", RainSuppressionAck{success}},
      {"aa01100000080078c70104019cd8f94a", SetFanRequest{Switch::on}},
      {"aa011000010800a49d0104000a95e119", SetFanAck{success}},
      {"aa010f000009001c000105412391c6", GetFanRequest{}},
      {"aa011100010900388f010500012370ab39", GetFanAck{success, Switch::on}},
      {"aa011000000900a0de0106030bfc22a4", SetReturnModeRequest{Echoes::triple}},
      {"aa0110000109007c84010600b1d03419", SetReturnModeAck{success}},
      {"aa010f00000a00742a0107192c4365", GetReturnModeRequest{}},
      {"aa011100010a0050a50107000310787835", GetReturnModeAck{success, Echoes::triple}},
      {"aa011000000b0010ed010801dbfe69b1", SetImuRateRequest{ImuRate::hz_200}},
      {"aa011000010b00ccb70108004db371e2", SetImuRateAck{success}},
      {"aa010f00000c00a47e0109f6dd4319", GetImuRateRequest{}},
      {"aa011100010c0080f10109000195482ac8", GetImuRateAck{success, ImuRate::hz_200}},
      {"aa011700001700fde1010a14090a1100e9a4350f14ecd3", SetUtcTimeRequest{{utc_2020_09_10_17_15}}},
      {"aa011000011700fd8b010a005af18556", SetUtcTimeAck{success}},
      // Set 2.
      {"aa010f00001e0085d80200887cd7c0", HubListLidarsRequest{}},
      {"aa012800011e0014d20200000130544644464737303036303138383100010308000002015064adfe",
       HubListLidarsAck{success, {{"0TFDFG700601881", DeviceType::mid40, {3, 8, 0, 0}, 2, 1}}}},
  };
  return examples;
}

}  // namespace rigcal::livox
