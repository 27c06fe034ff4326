#include "drivers/gige_codec/command.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "tests/support/hex.h"
#include "tests/support/mutations.h"

namespace rigcal::gige {
namespace {

using testing::HasSubstr;

struct Example {
  const char* name;
  Request request;
  std::vector<std::uint8_t> bytes;
};

// By hand from the layouts of the standard.
const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      {"discovery", DiscoveryRequest{}, from_hex("42 11 0002 0000 1234")},
      {"force_ip", ForceIpRequest{{0x00, 0x11, 0x22, 0x33, 0x44, 0x55}, {10, 0, 0, 7}, {255, 0, 0, 0}, {10, 0, 0, 1}},
       from_hex("42 01 0004 0038 1234 0000 001122334455 000000000000000000000000 0A000007"
                "000000000000000000000000 FF000000 000000000000000000000000 0A000001")},
      {"packet_resend", ResendRequest{0, 0xFFFF, 3, 0x10203},
       from_hex("42 00 0040 000C 1234 0000 FFFF 00000003 00010203")},
      {"read_registers", ReadRegistersRequest{{0x0A00, 0x0934}}, from_hex("42 01 0080 0008 1234 00000A00 00000934")},
      {"write_registers", WriteRegistersRequest{{{0x0A00, 2}}}, from_hex("42 01 0082 0008 1234 00000A00 00000002")},
      {"read_memory", ReadMemoryRequest{0x0200, 512}, from_hex("42 01 0084 0008 1234 00000200 0000 0200")},
      {"write_memory", WriteMemoryRequest{0x00E8, {'l', 'e', 'f', 't'}},
       from_hex("42 01 0086 0008 1234 000000E8 6C656674")},
  };
  return all;
}

TEST(GigeCommand, IsWrittenAndReadAsTheStandardHasIt) {
  for (const Example& example : examples()) {
    EXPECT_EQ(encode_request(example.request, 0x1234), example.bytes) << example.name;
    const auto frame = parse_command(example.bytes);
    ASSERT_TRUE(frame.has_value()) << example.name << ": " << frame.error().message();
    EXPECT_EQ(frame->id, 0x1234) << example.name;
    const auto request = decode_request(*frame);
    ASSERT_TRUE(request.has_value()) << example.name << ": " << request.error().message();
    EXPECT_EQ(*request, example.request) << example.name;
  }
}

TEST(GigeCommand, SaysWhetherItWantsAnAckAndWhatItsFlagMeans) {
  const auto discovery = parse_command(from_hex("42 11 0002 0000 0001"));
  EXPECT_TRUE(discovery->wants_ack);
  EXPECT_FALSE(discovery->extended_ids);
  const auto resend = parse_command(from_hex("42 10 0040 0000 0001"));
  EXPECT_FALSE(resend->wants_ack);
  EXPECT_TRUE(resend->extended_ids);
}

TEST(GigeCommand, CutAnywhereIsRefused) {
  for (const Example& example : examples()) {
    for (std::size_t size = 0; size < example.bytes.size(); ++size) {
      const auto frame = parse_command(ByteView(example.bytes).first(size));
      ASSERT_FALSE(frame.has_value()) << example.name << " of " << size << " bytes";
      EXPECT_THAT(frame.error().where, HasSubstr("byte ")) << example.name;
    }
  }
}

TEST(GigeCommand, BytesAfterItArePadding) {
  auto bytes = examples()[3].bytes;
  bytes.resize(bytes.size() + 20);
  EXPECT_EQ(*decode_request(*parse_command(bytes)), examples()[3].request);
}

TEST(GigeCommand, WrongFieldsAreNamed) {
  const auto why = [](const char* hex) {
    const auto bytes = from_hex(hex);
    const auto frame = parse_command(bytes);
    if (!frame) return frame.error().message();
    const auto request = decode_request(*frame);
    return request ? std::string() : request.error().message();
  };
  EXPECT_THAT(why("41 01 0080 0004 0001 00000A00"), HasSubstr("byte 0"));
  EXPECT_THAT(why("42 01 0080 0004 0000 00000A00"), HasSubstr("id 0"));
  EXPECT_THAT(why("42 01 0080 0008 0001 00000A00"), HasSubstr("longer than the datagram"));
  EXPECT_THAT(why("42 01 0080 0003 0001 000A00"), HasSubstr("3 bytes"));
  EXPECT_THAT(why("42 01 0080 0000 0001"), HasSubstr("0 bytes"));
  EXPECT_THAT(why("42 01 0082 0004 0001 00000A00"), HasSubstr("4 bytes"));
  EXPECT_THAT(why("42 01 0002 0004 0001 00000000"), HasSubstr("4 bytes"));
  EXPECT_THAT(why("42 01 0100 0000 0001"), HasSubstr("256 is not known"));
  EXPECT_THAT(why("42 01 0088 0004 0001 00000000"), HasSubstr("136 is not known"));
  EXPECT_THAT(why("42 00 0040 000C 0001 0000 0001 00000004 00000003"), HasSubstr("backwards"));
  EXPECT_THAT(why("42 10 0040 0014 0001 0000 0000 00000001 00000001 00000000 00000001"), HasSubstr("64 bits"));
}

TEST(GigeCommand, NoMoreThanAFrameMayAskForIsTaken) {
  const auto ask = [](std::size_t registers) {
    std::vector<std::uint8_t> bytes = from_hex("42 01 0080 0000 0001");
    bytes[4] = static_cast<std::uint8_t>((4 * registers) >> 8U);
    bytes[5] = static_cast<std::uint8_t>(4 * registers);
    bytes.resize(bytes.size() + 4 * registers);
    return decode_request(*parse_command(bytes)).has_value();
  };
  EXPECT_TRUE(ask(135));
  EXPECT_FALSE(ask(136));
}

TEST(GigeCommand, DamagedOnesAreRefusedOrReadTheSameAgain) {
  Random random(7);
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto bytes = mutated(examples()[static_cast<std::size_t>(i) % examples().size()].bytes, random);
    const auto frame = parse_command(bytes);
    if (!frame) continue;
    const auto request = decode_request(*frame);
    if (!request) continue;
    ++taken;
    const auto again = encode_request(*request, frame->id);
    EXPECT_EQ(*decode_request(*parse_command(again)), *request);
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace rigcal::gige
