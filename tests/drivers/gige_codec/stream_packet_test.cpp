#include "drivers/gige_codec/stream_packet.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/records/pixel_format.h"
#include "drivers/gige_codec/chunks.h"
#include "drivers/gige_codec/pixel_code.h"
#include "tests/support/hex.h"
#include "tests/support/mutations.h"

namespace rigcal::gige {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const ImageLeader leader{true, 0x0123'4567'89AB'CDEF, 0x01080009, 1280, 1024, 8, 2, 0, 0};

TEST(GigeStream, HeadersAreAsTheStandardHasThem) {
  const auto header = make_stream_header({Status::packet_unavailable, 0x1234, PacketKind::payload, 0x010203, {}});
  EXPECT_THAT(header, ElementsAre(0x80, 0x0C, 0x12, 0x34, 3, 1, 2, 3));
  const auto packet = parse_stream_packet(from_hex("0100 FFFF 01 000000 AABB"));
  ASSERT_TRUE(packet.has_value());
  EXPECT_EQ(packet->status, Status::packet_resent);
  EXPECT_EQ(packet->block, 0xFFFF);
  EXPECT_EQ(packet->kind, PacketKind::leader);
  EXPECT_EQ(packet->packet, 0U);
  EXPECT_EQ(packet->payload.size(), 2U);
}

TEST(GigeStream, LeadersAndTrailersAreAsTheStandardHasThem) {
  const auto bytes = from_hex("0000 4001 0123456789ABCDEF 01080009 00000500 00000400 00000008 00000002 0000 0000");
  EXPECT_EQ(encode_leader(leader), bytes);
  EXPECT_EQ(*decode_leader(bytes), leader);
  EXPECT_EQ(encode_trailer({false, 1024, 0}), from_hex("0000 0001 00000400"));
  EXPECT_EQ(*decode_trailer(from_hex("0000 0001 00000400")), (ImageTrailer{false, 1024, 0}));
  EXPECT_EQ(encode_trailer({true, 1024, 5}), from_hex("0000 4001 00000400 00000005"));
  EXPECT_EQ(*decode_trailer(from_hex("0000 4001 00000400 00000005")), (ImageTrailer{true, 1024, 5}));
}

TEST(GigeStream, WhatIsCutOrOfAnotherKindIsRefused) {
  const auto bytes = encode_leader(leader);
  for (std::size_t size = 0; size < bytes.size(); ++size)
    EXPECT_FALSE(decode_leader(ByteView(bytes).first(size)).has_value()) << size;
  const auto trailer = encode_trailer({true, 1024, 5});
  for (std::size_t size = 0; size < trailer.size(); ++size)
    EXPECT_FALSE(decode_trailer(ByteView(trailer).first(size)).has_value()) << size;
  EXPECT_FALSE(decode_leader(from_hex("0000 0006 0123456789ABCDEF")).has_value());
  EXPECT_FALSE(parse_stream_packet(from_hex("0000 0001 03 0000")).has_value());
  EXPECT_THAT(parse_stream_packet(from_hex("0000 0001 83 000000")).error().what, HasSubstr("64 bits"));
  EXPECT_THAT(parse_stream_packet(from_hex("0000 0001 04 000000")).error().what, HasSubstr("kind 4"));
  EXPECT_FALSE(parse_stream_packet(from_hex("0000 0001 00 000000")).has_value());
}

TEST(GigeStream, BlocksCountRoundWithoutZero) {
  EXPECT_EQ(next_block(1), 2);
  EXPECT_EQ(next_block(65534), 65535);
  EXPECT_EQ(next_block(65535), 1);
}

TEST(GigeStream, ChunksAreFoundFromTheEnd) {
  std::vector<std::uint8_t> block{1, 2, 3, 4, 5};
  close_chunk(block, 1, 5);
  block.insert(block.end(), {6, 7});
  close_chunk(block, 0x1003, 2);
  EXPECT_EQ(block, from_hex("0102030405 00000001 00000005 0607 00001003 00000002"));
  const auto chunks = split_chunks(block);
  ASSERT_TRUE(chunks.has_value());
  ASSERT_EQ(chunks->size(), 2U);
  EXPECT_EQ((*chunks)[0].id, 1U);
  EXPECT_THAT((*chunks)[0].bytes, ElementsAre(1, 2, 3, 4, 5));
  EXPECT_EQ((*chunks)[1].id, 0x1003U);
  EXPECT_THAT((*chunks)[1].bytes, ElementsAre(6, 7));
  EXPECT_TRUE(split_chunks({})->empty());

  block[block.size() - 1] = 18;  // A byte more than there is before it.
  EXPECT_THAT(split_chunks(block).error().what, HasSubstr("18 bytes begins before the block"));
  EXPECT_THAT(split_chunks(from_hex("00 00001003 00000000")).error().what, HasSubstr("without its tag"));
}

TEST(GigeStream, DamagedPacketsAreRefusedOrReadTheSameAgain) {
  std::vector<std::uint8_t> block(64, 9);
  close_chunk(block, 1, 64);
  const auto header = make_stream_header({Status::success, 7, PacketKind::leader, 0, {}});
  std::vector<std::uint8_t> whole(header.begin(), header.end());
  const auto payload = encode_leader(leader);
  whole.insert(whole.end(), payload.begin(), payload.end());
  Random random(13);
  int taken = 0;
  for (int i = 0; i < 20000; ++i) {
    const auto bytes = mutated(whole, random);
    if (const auto packet = parse_stream_packet(bytes)) {
      const auto again = make_stream_header(*packet);
      EXPECT_EQ(parse_stream_packet(again)->packet, packet->packet);
      if (const auto found = decode_leader(packet->payload)) {
        ++taken;
        EXPECT_EQ(*decode_leader(encode_leader(*found)), *found);
      }
      if (const auto found = decode_trailer(packet->payload)) {
        EXPECT_EQ(*decode_trailer(encode_trailer(*found)), *found);
      }
    }
    const auto damaged = mutated(block, random);
    if (const auto chunks = split_chunks(damaged)) {
      std::size_t all = 0;
      for (const Chunk& chunk : *chunks) all += chunk.bytes.size() + kChunkTagBytes;
      EXPECT_EQ(all, damaged.size());
    }
  }
  EXPECT_GT(taken, 1000);
}

TEST(GigePixelCode, KnowsTheFormatsOfTheRigFileByTheirNumbers) {
  EXPECT_EQ(pixel_code("Mono8"), 0x01080001U);
  EXPECT_EQ(pixel_code("BayerRG8"), 0x01080009U);
  EXPECT_EQ(pixel_code("BayerRG12"), 0x01100011U);
  EXPECT_EQ(pixel_code("Mono12Packed"), std::nullopt);
  EXPECT_EQ(pixel_name(0x0110000D), "BayerRG10");
  EXPECT_EQ(pixel_name(0x010C0006), "");
  // The number says how many bits a pixel takes in memory.
  for (const char* name : {"Mono8", "Mono10", "Mono12", "Mono14", "Mono16", "BayerGR8", "BayerBG10", "BayerGB12",
                           "BayerRG16", "RGB8", "BGR8", "RGB16", "BGR16"}) {
    const PixelFormat format = *parse_pixel_format(name);
    EXPECT_EQ(bits_of_pixel(*pixel_code(name)), static_cast<unsigned>(format.stored_bits() * format.channels()))
        << name;
    EXPECT_EQ(pixel_name(*pixel_code(name)), name);
  }
}

}  // namespace
}  // namespace rigcal::gige
