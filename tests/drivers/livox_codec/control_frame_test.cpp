#include "drivers/livox_codec/control_frame.h"

#include <gtest/gtest.h>

#include <optional>
#include <string>

#include "core/base/random.h"
#include "drivers/livox_codec/commands.h"
#include "tests/drivers/livox_codec/worked_examples.h"
#include "tests/support/hex.h"

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

TEST(ControlFrame, ReadsAndWritesEveryWorkedExampleToTheByte) {
  for (const auto& [hex, payload] : worked_examples()) {
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

TEST(CommandName, IsFoundAgain) {
  for (unsigned set = 0; set < 3; ++set) {
    for (unsigned id = 0; id < 0x40; ++id) {
      const auto command = static_cast<Command>(set << 8U | id);
      const std::string name = command_name(command);
      const bool is_known = name.find("_0x") == std::string::npos;
      EXPECT_EQ(find_command(name), is_known ? std::optional(command) : std::nullopt) << name;
    }
  }
  EXPECT_FALSE(find_command("").has_value());
}

}  // namespace
}  // namespace rigcal::livox
