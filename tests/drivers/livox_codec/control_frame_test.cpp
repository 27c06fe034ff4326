#include "drivers/livox_codec/control_frame.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "tests/drivers/livox_codec/hex.h"

namespace rigcal::livox {
namespace {

struct ChecksumExample {
  std::string hex;
  std::uint16_t crc16;
  std::uint32_t crc32;
};

TEST(Checksums, AgreeWithTheTestVectorsOfTheProtocol) {
  const std::vector<ChecksumExample> examples{
      {"", 0x4C49, 0x564F580A},
      {"00", 0xDF89, 0x328149CB},
      {"AA", 0xD5D9, 0x0482033D},
      {"313233343536373839", 0xAB4E, 0xB08DB5B1},
      {"00010203040506", 0xFA9B, 0xDD3043CB},
      {"000102030405060708090a0b0c0d0e0f101112131415161718191a1b1c1d1e1f", 0xA08D, 0x282396AA},
  };
  for (const ChecksumExample& example : examples) {
    EXPECT_EQ(crc16(from_hex(example.hex)), example.crc16) << example.hex;
    EXPECT_EQ(crc32(from_hex(example.hex)), example.crc32) << example.hex;
  }
}

/// Every control frame among the protocol's worked examples and frames of real devices.
const std::vector<std::string>& worked_examples() {
  static const std::vector<std::string> frames{
      "aa01170000000064390001c0a82101bd07e8fd1e25f912",
      "aa0110000100006453000100f1343c29",
      "aa010f0000000004d7000338ba8d0c",
      "aa012200024800fff60000315051444c3548303031554c3939310002e8fdc51185fc",
      "aa012200020000597e0000334a45444b3338303031305a333931000700009dbd7ad7",
      "aa01220002010081670000334a45444b3338303031305a3339310007e8fd6d3c532f",
      "aa012200020000597e0000305446444647373030363031383831000100003fe90e9a",
      "aa012200020000597e000030544644464737303036303138383200010000ef93aedd",
      "aa012200020000597e0000305446444647373030363031383833000100005fbacee0",
      "aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0",
      "aa0119000002006c6b0001c0a80105c1dacdd8c1dab272ff8a",
      "aa01170000000064390001c0a82101bd07e8fd1e25f912",
      "aa011000010200d460000100837afa4c",
      "aa010f000003006cfd0002dae45636",
      "aa0114000103001c540002000b090000ef4d0992",
      "aa010f0000040064b0000388d2a2e1",
      "aa0116000104009c0f0003000100000000006a78b53c",
      "aa0116000104009c0f0003000000280000001e2c6f92",
      "aa0116000104009c0f0003000100406800405ffbb997",
      "aa0110000005000077000401ff363cfe",
      "aa011000010500dc2d000400697b24ad",
      "aa011000000600685d000400226f1ede",
      "aa0110000005000077000501be0727e7",
      "aa011000000600685d000500635e05c7",
      "aa011000010600b40700050063231ae3",
      "aa010f00000d007c6700060a2bacab",
      "aa011000010d001ce300060062267ad3",
      "aa011300020900d476000740680040a0d80068",
      "aa011c00001800d925000801c0a8014dffffff00c0a801012895c4d0",
      "aa011400001800f97f000801c0a8014d41a0bda4",
      "aa0110000118003508000800c933b0b5",
      "aa010f00000d007c6700099b36133b",
      "aa011d00010d00689f00090001c0a80165ffffff00c0a801017cb63762",
      "aa011500010d0048c500090001c0a801650924a46f",
      "aa011100001a001d6a000a0004555a3ba8",
      "aa011000011a00853b000a00391f40e2",
      "aa01140000100039b1000b020001000124ab34ce",
      "aa01130001100039db000b00000000a9f80c7a",
      "aa01130001100039db000b01020001347b33b6",
      "aa0112000011007993000c010200cb8ff703",
      "aa0118000111000d85000c0000000002000100013fe8729c",
      "aa01130000140085e6000d00000000c975c475",
      "aa011500001500c5c4000d010201000200b53e7acb",
      "aa01130001140059bc000d00000000a37f5d62",
      "aa011000001900314b010002e3e85984",
      "aa011000011900ed11010000cff4484e",
      "aa011000011900ed11010002e39546a0",
      "aa012700000700bda001010000c03f000010c00000b4426400000038ffffff2c010000c2f9222a",
      "aa0110000107006c1e01010069ab57b4",
      "aa010f00000800c4190102ce6cbe63",
      "aa01280001080055130102000000c03f000010c00000b4426400000038ffffff2c010000a0b9771c",
      "aa01100000080078c70103015b4eb805",
      "aa0110000109007c84010300f4244364",
      "aa01100000080078c70104019cd8f94a",
      "aa011000010800a49d0104000a95e119",
      "aa010f000009001c000105412391c6",
      "aa011100010900388f010500012370ab39",
      "aa011000000900a0de0106030bfc22a4",
      "aa0110000109007c84010600b1d03419",
      "aa010f00000a00742a0107192c4365",
      "aa011100010a0050a50107000310787835",
      "aa011000000b0010ed010801dbfe69b1",
      "aa011000010b00ccb70108004db371e2",
      "aa010f00000c00a47e0109f6dd4319",
      "aa011100010c0080f10109000195482ac8",
      "aa011700001700fde1010a14090a1100e9a4350f14ecd3",
      "aa011000011700fd8b010a005af18556",
      "aa010f00001e0085d80200887cd7c0",
      "aa012800011e0014d20200000130544644464737303036303138383100010308000002015064adfe",
  };
  return frames;
}

TEST(ControlFrame, ReadsAndWritesEveryWorkedExampleToTheByte) {
  for (const std::string& hex : worked_examples()) {
    const std::vector<std::uint8_t> bytes = from_hex(hex);
    const Expected<ControlFrame> frame = parse_control_frame(bytes);
    ASSERT_TRUE(frame) << hex << ": " << frame.error().message();
    EXPECT_EQ(make_control_frame(*frame), bytes) << hex;
  }
}

TEST(ControlFrame, GivesTheFieldsOfTheFirstWorkedExample) {
  const auto bytes = from_hex("aa012200020000597e0000334a45444b3338303031305a333931000700009dbd7ad7");
  const Expected<ControlFrame> frame = parse_control_frame(bytes);
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->type, FrameType::message);
  EXPECT_EQ(frame->seq, 0);
  EXPECT_EQ(frame->set, CommandSet::general);
  EXPECT_EQ(frame->id, 0);
  EXPECT_EQ(frame->payload.size(), 19U);
}

TEST(ControlFrame, RefusesEveryShortenedFrameAndEveryFlippedBit) {
  const auto bytes = from_hex("aa011900010200b0310001c0a80105c1dacdd8c1daf45d01b0");
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    EXPECT_FALSE(parse_control_frame(ByteView(bytes).first(size))) << size;
  }
  for (std::size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    auto damaged = bytes;
    damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ (1U << (bit % 8)));
    EXPECT_FALSE(parse_control_frame(damaged)) << bit;
  }
}

TEST(ControlFrame, RefusesALengthOfZeroWithARightHeaderChecksum) {
  std::vector<std::uint8_t> bytes = from_hex("aa0100000000000000");
  const std::uint16_t checksum = crc16(ByteView(bytes).first(7));
  bytes[7] = static_cast<std::uint8_t>(checksum & 0xFFU);
  bytes[8] = static_cast<std::uint8_t>(checksum >> 8U);
  bytes.resize(64, 0);
  const Expected<ControlFrame> frame = parse_control_frame(bytes);
  ASSERT_FALSE(frame);
  EXPECT_NE(frame.error().message().find("offset 2"), std::string::npos) << frame.error().message();
}

TEST(ControlFrame, ComesBackFromARoundTripOfRandomPayloads) {
  Random random(7);
  for (int i = 0; i < 200; ++i) {
    std::vector<std::uint8_t> payload(random.below(kMaxFrameBytes - kMinFrameBytes + 1));
    for (std::uint8_t& byte : payload) byte = static_cast<std::uint8_t>(random.below(256));
    ControlFrame frame{static_cast<FrameType>(random.below(3)), static_cast<std::uint16_t>(random.below(65536)),
                       static_cast<CommandSet>(random.below(3)), static_cast<std::uint8_t>(random.below(256)), payload};
    const auto bytes = make_control_frame(frame);
    const Expected<ControlFrame> back = parse_control_frame(bytes);
    ASSERT_TRUE(back) << back.error().message();
    EXPECT_EQ(back->type, frame.type);
    EXPECT_EQ(back->seq, frame.seq);
    EXPECT_EQ(back->set, frame.set);
    EXPECT_EQ(back->id, frame.id);
    EXPECT_EQ(std::vector<std::uint8_t>(back->payload.begin(), back->payload.end()), payload);
  }
}

}  // namespace
}  // namespace rigcal::livox
