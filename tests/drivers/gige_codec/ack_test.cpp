#include "drivers/gige_codec/ack.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/support/hex.h"
#include "tests/support/mutations.h"

namespace rigcal::gige {
namespace {

using testing::HasSubstr;

struct Example {
  Ack ack;
  std::vector<std::uint8_t> bytes;
};

const std::vector<Example>& examples() {
  static const std::vector<Example> all{
      {ForceIpAck{}, from_hex("0000 0005 0000 1234")},
      {ReadRegistersAck{{2, 0x8000'0001}}, from_hex("0000 0081 0008 1234 00000002 80000001")},
      {WriteRegistersAck{1}, from_hex("0000 0083 0004 1234 0000 0001")},
      {ReadMemoryAck{0x0200, {'L', 'o', 'c', 'a'}}, from_hex("0000 0085 0008 1234 00000200 4C6F6361")},
      {WriteMemoryAck{16}, from_hex("0000 0087 0004 1234 0000 0010")},
      {PendingAck{1500}, from_hex("0000 0089 0004 1234 0000 05DC")},
  };
  return all;
}

TEST(GigeAck, IsWrittenAndReadAsTheStandardHasIt) {
  for (const Example& example : examples()) {
    EXPECT_EQ(encode_ack(example.ack, 0x1234), example.bytes);
    const auto frame = parse_ack(example.bytes);
    ASSERT_TRUE(frame.has_value());
    EXPECT_EQ(frame->id, 0x1234);
    EXPECT_EQ(frame->status, Status::success);
    const auto ack = decode_ack(*frame);
    ASSERT_TRUE(ack.has_value()) << ack.error().message();
    EXPECT_EQ(*ack, example.ack);
  }
}

TEST(GigeAck, OfADiscoveryIsTheDevicesIdentity) {
  DeviceIdentity identity;
  identity.model = "MV-CA013-21UC";
  const auto bytes = encode_ack(identity, 9);
  EXPECT_EQ(bytes.size(), kHeaderBytes + DeviceIdentity::kBytes);
  EXPECT_EQ(*decode_ack(*parse_ack(bytes)), Ack(identity));
}

TEST(GigeAck, ARefusalHasTheCommandsNumbersAndNoPayload) {
  const auto command = from_hex("42 01 0100 0000 0007");
  EXPECT_EQ(make_refusal(*parse_command(command), Status::not_implemented), from_hex("8001 0101 0000 0007"));
  EXPECT_STREQ(to_string(parse_ack(from_hex("8006 0083 0000 0001"))->status), "access denied");
  EXPECT_TRUE(is_error(Status::access_denied));
  EXPECT_FALSE(is_error(Status::packet_resent));
}

TEST(GigeAck, CutOrOfAnotherLengthIsRefused) {
  for (const Example& example : examples()) {
    for (std::size_t size = 0; size < example.bytes.size(); ++size)
      EXPECT_FALSE(parse_ack(ByteView(example.bytes).first(size)).has_value());
  }
  const auto why = [](const char* hex) {
    const auto bytes = from_hex(hex);
    const auto ack = decode_ack(*parse_ack(bytes));
    return ack ? std::string() : ack.error().message();
  };
  EXPECT_THAT(why("0000 0081 0003 0001 000000"), HasSubstr("3 bytes"));
  EXPECT_THAT(why("0000 0083 0002 0001 0000"), HasSubstr("2 bytes"));
  EXPECT_THAT(why("0000 0085 0002 0001 0000"), HasSubstr("2 bytes"));
  EXPECT_THAT(why("0000 0089 0000 0001"), HasSubstr("0 bytes"));
  EXPECT_THAT(why("0000 0003 0004 0001 00000000"), HasSubstr("248 bytes"));
  EXPECT_THAT(why("0000 00C1 0000 0001"), HasSubstr("193 is not known"));
}

TEST(GigeAck, DamagedOnesAreRefusedOrReadTheSameAgain) {
  Random random(11);
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto bytes = mutated(examples()[static_cast<std::size_t>(i) % examples().size()].bytes, random);
    const auto frame = parse_ack(bytes);
    if (!frame) continue;
    const auto ack = decode_ack(*frame);
    if (!ack) continue;
    ++taken;
    EXPECT_EQ(*decode_ack(*parse_ack(encode_ack(*ack, frame->id, frame->status))), *ack);
  }
  EXPECT_GT(taken, 1000);
}

}  // namespace
}  // namespace rigcal::gige
