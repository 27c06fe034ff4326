#include "core/io/ip_reassembler.h"

#include <gtest/gtest.h>

#include <numeric>

#include "core/base/random.h"

namespace rigcal {
namespace {

using Bytes = std::vector<std::uint8_t>;

Bytes counting(std::size_t size, std::uint8_t start = 0) {
  Bytes bytes(size);
  std::iota(bytes.begin(), bytes.end(), start);
  return bytes;
}

IpPart part(const Bytes& data, std::size_t offset, std::size_t size, bool more, std::uint16_t id = 1) {
  return {{10, 0, 0, 1}, {10, 0, 0, 2}, id, offset, more, ByteView(data).subspan(offset, size)};
}

TEST(IpReassembler, PutsPartsInAnyOrderTogether) {
  const Bytes data = counting(53);
  std::vector<IpPart> parts{part(data, 0, 16, true), part(data, 16, 8, true), part(data, 24, 24, true),
                            part(data, 48, 5, false)};
  std::vector<std::size_t> order{0, 1, 2, 3};
  do {
    IpReassembler reassembler;
    for (std::size_t i = 0; i < 4; ++i) {
      const std::optional<IpPart> whole = reassembler.add(parts[order[i]], 0);
      ASSERT_EQ(whole.has_value(), i == 3);
      if (!whole) continue;
      EXPECT_TRUE(Bytes(whole->data.begin(), whole->data.end()) == data);
      EXPECT_FALSE(whole->is_fragment());
      EXPECT_EQ(whole->from, parts[0].from);
      EXPECT_EQ(whole->to, parts[0].to);
    }
    EXPECT_EQ(reassembler.counters().whole, 1U);
    EXPECT_EQ(reassembler.counters().lost(), 0U);
  } while (std::next_permutation(order.begin(), order.end()));
}

TEST(IpReassembler, KeepsPacketsOfOthersApart) {
  const Bytes a = counting(16);
  const Bytes b = counting(16, 100);
  IpReassembler reassembler;
  IpPart other_sender = part(b, 0, 8, true);
  other_sender.from[3] = 9;
  IpPart other_receiver = part(b, 0, 8, true);
  other_receiver.to[3] = 9;
  EXPECT_FALSE(reassembler.add(other_sender, 0));
  EXPECT_FALSE(reassembler.add(other_receiver, 0));
  EXPECT_FALSE(reassembler.add(part(b, 0, 8, true, 2), 0));
  EXPECT_FALSE(reassembler.add(part(a, 0, 8, true), 0));
  const std::optional<IpPart> whole = reassembler.add(part(a, 8, 8, false), 0);
  ASSERT_TRUE(whole);
  EXPECT_TRUE(Bytes(whole->data.begin(), whole->data.end()) == a);
  reassembler.finish();
  EXPECT_EQ(reassembler.counters().incomplete, 3U);
}

TEST(IpReassembler, TakesOverlapsThatAgreeAndCountsDuplicates) {
  const Bytes data = counting(40);
  IpReassembler reassembler;
  EXPECT_FALSE(reassembler.add(part(data, 0, 16, true), 0));
  EXPECT_FALSE(reassembler.add(part(data, 0, 16, true), 0));
  EXPECT_FALSE(reassembler.add(part(data, 8, 16, true), 0));
  EXPECT_TRUE(reassembler.add(part(data, 16, 24, false), 0));
  EXPECT_EQ(reassembler.counters().duplicates, 1U);
  EXPECT_EQ(reassembler.counters().whole, 1U);
}

// Each list is an attack: with it the packet must be refused, also when all parts are there in the end.
TEST(IpReassembler, RefusesPartsThatContradictEachOther) {
  const Bytes data = counting(70'000);
  Bytes other = data;
  other[15] ^= 1;
  const std::vector<std::vector<IpPart>> attacks{
      {part(data, 0, 16, true), part(other, 8, 8, true)},             // another byte
      {part(data, 16, 8, false), part(data, 24, 8, true)},            // beyond the end
      {part(data, 16, 8, false), part(data, 24, 8, false)},           // two ends
      {part(data, 16, 8, true), part(data, 8, 8, false)},             // the end before a part
      {part(data, 0, 9, true)},                                       // no multiple of 8
      {part(data, 0, 0, true)},                                       // empty
      {part(data, 65'528, 8, false)},                                 // longer than any packet
      {part(data, 65'512, 3, false), part(data, 65'512, 4, false)}};  // one byte too many
  for (const std::vector<IpPart>& attack : attacks) {
    IpReassembler reassembler;
    for (const IpPart& each : attack) EXPECT_FALSE(reassembler.add(each, 0));
    EXPECT_EQ(reassembler.counters().contradictory, 1U) << &attack - attacks.data();
    EXPECT_FALSE(reassembler.add(part(data, 0, 16, true), 1));
    EXPECT_FALSE(reassembler.add(part(data, 16, 8, false), 1));
    reassembler.finish();
    EXPECT_EQ(reassembler.counters().contradictory, 1U);
    EXPECT_EQ(reassembler.counters().incomplete, 0U);
  }
}

TEST(IpReassembler, TakesTheLongestPacket) {
  const Bytes data = counting(65'515);
  IpReassembler reassembler;
  EXPECT_FALSE(reassembler.add(part(data, 65'504, 11, false), 0));
  EXPECT_TRUE(reassembler.add(part(data, 0, 65'504, true), 0));
}

TEST(IpReassembler, ForgetsPartsAfterTheirTimeWhicheverWayTheStampsGo) {
  const Bytes data = counting(16);
  for (const std::int64_t later : {IpReassembler::max_wait_ns, -IpReassembler::max_wait_ns}) {
    const std::int64_t start = 10'000'000'000;
    IpReassembler in_time;
    EXPECT_FALSE(in_time.add(part(data, 0, 8, true), start));
    EXPECT_TRUE(in_time.add(part(data, 8, 8, false), start + later));
    IpReassembler too_late;
    EXPECT_FALSE(too_late.add(part(data, 0, 8, true), start));
    EXPECT_FALSE(too_late.add(part(data, 8, 8, false), start + later + (later > 0 ? 1 : -1)));
    EXPECT_EQ(too_late.counters().incomplete, 1U);
  }
}

TEST(IpReassembler, GivesTheOldestUpWhenTooManyWait) {
  const Bytes data = counting(16);
  IpReassembler reassembler;
  constexpr std::uint16_t flood = 1000;
  for (std::uint16_t id = 0; id < flood; ++id) EXPECT_FALSE(reassembler.add(part(data, 0, 8, true, id), 0));
  EXPECT_EQ(reassembler.counters().crowded_out, flood - IpReassembler::max_waiting);
  EXPECT_TRUE(reassembler.add(part(data, 8, 8, false, flood - 1), 0));
  EXPECT_FALSE(reassembler.add(part(data, 8, 8, false, 0), 0));
}

TEST(IpReassembler, DeliversOnlyWhatWasSentInAStorm) {
  Random random(7);
  const Bytes data = counting(800);
  IpReassembler reassembler;
  for (std::int64_t i = 0; i < 20'000; ++i) {
    const auto id = static_cast<std::uint16_t>(random.uniform() * 20);
    const std::size_t offset = 8 * static_cast<std::size_t>(random.uniform() * 100);
    const bool last = offset + 80 >= data.size();
    const std::size_t size = last ? data.size() - offset : 80;
    const std::optional<IpPart> whole = reassembler.add(part(data, offset, size, !last, id), i * 1'000'000);
    if (!whole) continue;
    ASSERT_TRUE(Bytes(whole->data.begin(), whole->data.end()) == data);
  }
  reassembler.finish();
  const FragmentCounters& counters = reassembler.counters();
  EXPECT_GT(counters.whole, 100U);
  EXPECT_EQ(counters.fragments, 20'000U);
  EXPECT_EQ(counters.contradictory, 0U);
}

}  // namespace
}  // namespace rigcal
