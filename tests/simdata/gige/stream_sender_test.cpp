#include "simdata/gige/stream_sender.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <map>
#include <numeric>

#include "drivers/gige_codec/chunks.h"
#include "drivers/gige_codec/pixel_code.h"
#include "simdata/gige/test_pattern.h"

namespace rigcal::sim {
namespace {

using gige::PacketKind;
using gige::Status;
using testing::ElementsAre;

constexpr std::uint32_t packet_bytes = 576;
constexpr std::size_t room = packet_bytes - 36;

FrameOrder order_of(std::uint16_t block, int height = 20) {
  FrameOrder order;
  order.block = block;
  order.number = block - 1U;
  order.ticks = 1000U + block;
  order.settings.width = 160;
  order.settings.height = height;
  order.settings.pixel_format = *gige::pixel_code("Mono8");
  order.settings.image_bytes = 160U * static_cast<unsigned>(height);
  return order;
}

std::vector<std::uint8_t> image_of(const FrameOrder& order) {
  std::vector<std::uint8_t> image(order.settings.image_bytes);
  std::iota(image.begin(), image.end(), static_cast<std::uint8_t>(order.block));
  return image;
}

struct Seen {
  Status status{};
  std::uint16_t block = 0;
  PacketKind kind{};
  std::uint32_t packet = 0;
  std::vector<std::uint8_t> payload;
};

class Stream : public testing::Test {
 protected:
  /// What leaves until nothing waits any more.
  static std::vector<Seen> drain(StreamSender& sender, std::int64_t& now_ns) {
    std::vector<Seen> seen;
    std::vector<StreamSender::Outgoing> out;
    while (sender.deadline_ns() != INT64_MAX) {
      now_ns = std::max(now_ns, sender.deadline_ns());
      sender.take_due(now_ns, 64, out);
      for (const auto& outgoing : out) {
        std::vector<std::uint8_t> bytes(outgoing.packet.header.begin(), outgoing.packet.header.end());
        bytes.insert(bytes.end(), outgoing.packet.payload.begin(), outgoing.packet.payload.end());
        const auto packet = gige::parse_stream_packet(bytes);
        EXPECT_TRUE(packet.has_value());
        seen.push_back({packet->status,
                        packet->block,
                        packet->kind,
                        packet->packet,
                        {packet->payload.begin(), packet->payload.end()}});
      }
    }
    return seen;
  }

  const StreamTarget target{{{10, 0, 0, 1}, 50000}, packet_bytes, true, 0};
  std::int64_t now = 1'000'000'000;
};

TEST_F(Stream, ABlockIsALeaderItsPixelsAndATrailer) {
  StreamSender sender({}, 1e9, 1);
  const FrameOrder order = order_of(7);
  sender.add(order, image_of(order), target, now);
  const auto seen = drain(sender, now);
  ASSERT_EQ(seen.size(), 2 + (3200 + room - 1) / room);
  const auto leader = gige::decode_leader(seen.front().payload);
  ASSERT_TRUE(leader.has_value());
  EXPECT_EQ(leader->timestamp, 1007U);
  EXPECT_EQ(leader->width, 160U);
  EXPECT_EQ(leader->height, 20U);
  EXPECT_FALSE(leader->has_chunks);
  std::vector<std::uint8_t> pixels;
  for (std::size_t i = 1; i + 1 < seen.size(); ++i) {
    EXPECT_EQ(seen[i].packet, i);
    EXPECT_EQ(seen[i].kind, PacketKind::payload);
    EXPECT_EQ(seen[i].block, 7);
    if (i + 2 < seen.size()) {
      EXPECT_EQ(seen[i].payload.size(), room);
    }
    pixels.insert(pixels.end(), seen[i].payload.begin(), seen[i].payload.end());
  }
  EXPECT_TRUE(pixels == image_of(order));
  EXPECT_EQ(seen.back().kind, PacketKind::trailer);
  EXPECT_EQ(gige::decode_trailer(seen.back().payload)->height, 20U);
}

TEST_F(Stream, ChunksFollowTheImage) {
  StreamSender sender({}, 1e9, 1);
  FrameOrder order = order_of(7);
  order.settings.has_chunks = true;
  order.settings.chunks = {true, false, true, false};
  order.settings.exposure_us = 1500.0;
  sender.add(order, image_of(order), target, now);
  std::vector<std::uint8_t> block;
  for (const Seen& packet : drain(sender, now)) {
    if (packet.kind == PacketKind::payload) block.insert(block.end(), packet.payload.begin(), packet.payload.end());
    if (packet.kind == PacketKind::leader) {
      EXPECT_TRUE(gige::decode_leader(packet.payload)->has_chunks);
    }
    if (packet.kind == PacketKind::trailer) {
      EXPECT_TRUE(gige::decode_trailer(packet.payload)->has_chunks);
    }
  }
  const auto chunks = gige::split_chunks(block);
  ASSERT_TRUE(chunks.has_value());
  ASSERT_EQ(chunks->size(), 3U);
  EXPECT_EQ((*chunks)[0].bytes.size(), 3200U);
  EXPECT_EQ((*chunks)[1].id, chunk_id(ChunkKind::frame_id));
  EXPECT_THAT((*chunks)[1].bytes, ElementsAre(0, 0, 0, 0, 0, 0, 0, 6));
  EXPECT_EQ((*chunks)[2].id, chunk_id(ChunkKind::exposure_time));
  EXPECT_THAT((*chunks)[2].bytes, ElementsAre(0x40, 0x97, 0x70, 0, 0, 0, 0, 0));  // 1500 as a double.
}

TEST_F(Stream, PacketsLeaveAsFastAsTheLinkAndTheDelayHaveIt) {
  const auto time_of = [this](const StreamTarget& to, double link) {
    StreamSender sender({}, link, 1);
    const FrameOrder order = order_of(1, 1000);
    std::int64_t clock = now;
    sender.add(order, image_of(order), to, clock);
    drain(sender, clock);
    return static_cast<double>(clock - now) * 1e-9;
  };
  const double packets = std::ceil(160'000.0 / room);
  EXPECT_NEAR(time_of(target, 1e9), 8e-9 * (160'000 + packets * (36 + 38)), 2e-5);
  EXPECT_NEAR(time_of(target, 1e8), 8e-8 * (160'000 + packets * (36 + 38)), 2e-4);
  StreamTarget delayed = target;
  delayed.packet_delay_ns = 10'000;
  EXPECT_NEAR(time_of(delayed, 1e9), 8e-9 * (160'000 + packets * (36 + 38)) + packets * 1e-5, 5e-5);
}

TEST_F(Stream, LostPacketsAreCountedAndComeAgainWhenAskedFor) {
  StreamSender sender({0.2, 0.0}, 1e9, 5);
  std::map<std::uint32_t, int> seen;
  const FrameOrder order = order_of(3, 1000);
  sender.add(order, image_of(order), target, now);
  for (const Seen& packet : drain(sender, now)) ++seen[packet.packet];
  const std::uint32_t all = 2 + static_cast<std::uint32_t>((160'000 + room - 1) / room);
  EXPECT_EQ(seen.size() + sender.counts().lost, all);
  EXPECT_NEAR(static_cast<double>(sender.counts().lost), 0.2 * all, 25.0);
  for (int round = 0; round < 20 && seen.size() < all; ++round) {
    for (std::uint32_t packet = 0; packet < all; ++packet) {
      if (seen.count(packet) == 0) sender.resend({0, 3, packet, packet});
    }
    for (const Seen& packet : drain(sender, now)) {
      EXPECT_EQ(packet.status, Status::success);
      ++seen[packet.packet];
    }
  }
  EXPECT_EQ(seen.size(), all);
  EXPECT_GT(sender.counts().resent, sender.counts().lost / 2);
  EXPECT_EQ(sender.counts().damaged_blocks, 1U);
}

TEST_F(Stream, WhoeverWantsToKnowIsToldThatAPacketComesAgain) {
  StreamSender sender({}, 1e9, 5);
  const FrameOrder order = order_of(3);
  sender.add(order, image_of(order), target, now);
  drain(sender, now);
  sender.mark_resent(true);
  sender.resend({0, 3, 2, 4});
  const auto again = drain(sender, now);
  ASSERT_EQ(again.size(), 3U);
  EXPECT_EQ(again[0].status, Status::packet_resent);
  EXPECT_EQ(again[0].packet, 2U);
  EXPECT_EQ(again[2].packet, 4U);
}

TEST_F(Stream, OldBlocksAreForgottenAndSaidToBe) {
  StreamSender sender({}, 1e9, 5);
  for (std::uint16_t block = 1; block <= 40; ++block) {
    const FrameOrder order = order_of(block);
    sender.add(order, image_of(order), target, now);
    drain(sender, now);
  }
  EXPECT_EQ(sender.counts().skipped_blocks, 0U);
  sender.resend({0, 40, 1, 1});
  EXPECT_EQ(drain(sender, now)[0].status, Status::success);
  sender.resend({0, 5, 1, 3});
  const auto answer = drain(sender, now);
  ASSERT_EQ(answer.size(), 1U);
  EXPECT_EQ(answer[0].status, Status::packet_unavailable);
  EXPECT_EQ(answer[0].block, 5);
  EXPECT_TRUE(answer[0].payload.empty());
  EXPECT_EQ(sender.counts().not_there_any_more, 1U);
  // Packets that the block does not have are none.
  sender.resend({0, 40, 1000, 0xFFFFFF});
  EXPECT_TRUE(drain(sender, now).empty());
}

TEST_F(Stream, WhatWaitsTooLongIsSkippedAndCounted) {
  StreamSender sender({}, 1e6, 5);
  for (std::uint16_t block = 1; block <= 20; ++block) {
    const FrameOrder order = order_of(block);
    sender.add(order, image_of(order), target, now);
  }
  EXPECT_EQ(sender.counts().skipped_blocks, 20 - StreamSender::kKeptBlocks);
  EXPECT_EQ(drain(sender, now).front().block, 20 - StreamSender::kKeptBlocks + 1);
}

TEST_F(Stream, PacketsThatAreOvertakenAllArrive) {
  StreamSender sender({0.0, 0.1}, 1e9, 5);
  const FrameOrder order = order_of(3, 1000);
  sender.add(order, image_of(order), target, now);
  const auto seen = drain(sender, now);
  std::vector<std::uint32_t> numbers;
  for (const Seen& packet : seen) numbers.push_back(packet.packet);
  EXPECT_FALSE(std::is_sorted(numbers.begin(), numbers.end()));
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_LE(std::abs(static_cast<int>(numbers[i]) - static_cast<int>(i)), 12);
  std::sort(numbers.begin(), numbers.end());
  for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_EQ(numbers[i], i);
  EXPECT_GT(sender.counts().reordered, 10U);
}

TEST_F(Stream, ClearedItSendsNothing) {
  StreamSender sender({}, 1e9, 5);
  const FrameOrder order = order_of(3);
  sender.add(order, image_of(order), target, now);
  sender.clear();
  EXPECT_EQ(sender.deadline_ns(), INT64_MAX);
}

TEST(TestPatternOfCameras, MovesWithEveryFrameAndFillsEveryFormat) {
  TestPattern pattern;
  FrameWish wish;
  wish.number = 3;
  wish.pixel_format = "BayerRG8";
  wish.width = 40;
  wish.height = 10;
  wish.offset_x = 8;
  wish.offset_y = 2;
  std::vector<std::uint8_t> image;
  ASSERT_TRUE(pattern.make(wish, image));
  ASSERT_EQ(image.size(), 400U);
  EXPECT_EQ(image[5 * 40 + 7], TestPattern::value(3, 8 + 7, 2 + 5, 8));
  std::vector<std::uint8_t> next;
  wish.number = 4;
  ASSERT_TRUE(pattern.make(wish, next));
  for (std::size_t i = 0; i < image.size(); ++i) ASSERT_NE(image[i], next[i]);
  wish.pixel_format = "Mono12";
  ASSERT_TRUE(pattern.make(wish, image));
  ASSERT_EQ(image.size(), 800U);
  EXPECT_EQ(image[2 * 47] | image[2 * 47 + 1] << 8, TestPattern::value(4, 8 + 7, 2 + 1, 12));
  EXPECT_NE(TestPattern::value(1, 0, 0, 8), TestPattern::value(2, 0, 0, 8));
}

}  // namespace
}  // namespace rigcal::sim
