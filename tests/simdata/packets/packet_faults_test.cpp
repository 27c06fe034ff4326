#include "simdata/packets/packet_faults.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

namespace rigcal::sim {
namespace {

constexpr Endpoint kPoints{{192, 168, 1, 179}, 60001};
constexpr Endpoint kImu{{192, 168, 1, 179}, 60003};
constexpr Endpoint kHost{{192, 168, 1, 5}, 56001};
constexpr std::int64_t kStart = 1'700'000'000'000'000'000;

struct Arrived {
  std::int64_t stamp_ns = 0;
  Endpoint from;
  std::vector<std::uint8_t> bytes;
  bool operator==(const Arrived&) const = default;
  [[nodiscard]] std::uint32_t number() const {
    std::uint32_t number = 0;
    std::memcpy(&number, &bytes[4], 4);
    return number;
  }
};

/// 400 us apart; every twelfth from the IMU; bytes: the version, zeros, the packet's number.
std::vector<Arrived> run(const FaultOptions& options, std::uint64_t seed, int packets, PacketFaults* used = nullptr) {
  std::vector<Arrived> out;
  PacketFaults faults(options, seed, [&](const Datagram& datagram) -> Expected<void> {
    out.push_back({datagram.stamp_ns, datagram.from, {datagram.bytes.begin(), datagram.bytes.end()}});
    return {};
  });
  for (int i = 0; i < packets; ++i) {
    std::vector<std::uint8_t> bytes(8, 0);
    bytes[0] = 5;
    std::memcpy(&bytes[4], &i, 4);
    EXPECT_TRUE(faults.add({kStart + i * 400'000LL, i % 12 == 11 ? kImu : kPoints, kHost, bytes}));
  }
  EXPECT_TRUE(faults.flush());
  if (used != nullptr) *used = std::move(faults);
  return out;
}

/// What a stream's arrivals show when every number is known.
FaultCounts seen(const std::vector<Arrived>& arrived, const Endpoint& from, int packets) {
  std::vector<int> times(static_cast<std::size_t>(packets), 0);
  FaultCounts counts;
  std::uint32_t newest = 0;
  for (const Arrived& datagram : arrived) {
    if (datagram.from != from) continue;
    const std::uint32_t number = datagram.number();
    if (times[number]++ > 0) {
      ++counts.duplicated;
    } else if (number < newest) {
      ++counts.out_of_order;
    }
    newest = std::max(newest, number);
  }
  bool lost_before = false;
  bool any = false;
  for (int i = 0; i < packets; ++i) {
    if ((i % 12 == 11 ? kImu : kPoints) != from) continue;
    ++counts.sent;
    if (times[static_cast<std::size_t>(i)] == 0) {
      ++counts.lost;
      lost_before = true;
      ++(any ? counts.lost_at_end : counts.lost_at_start);
      continue;
    }
    if (lost_before && any) ++counts.gaps;
    lost_before = false;
    any = true;
    counts.lost_at_end = 0;
  }
  return counts;
}

TEST(PacketFaults, KnowsExactlyWhatItDid) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    FaultOptions options;
    options.loss = seed % 4 == 0 ? 0.2 : 0.02;
    options.duplicate = 0.01;
    options.reorder = 0.02;
    options.delay = 0.01;
    PacketFaults used({}, 0, {});
    const auto arrived = run(options, seed, 12'000, &used);
    for (const Endpoint& from : {kPoints, kImu}) {
      const FaultCounts truth = seen(arrived, from, 12'000);
      const FaultCounts& said = used.counts().at(from);
      EXPECT_EQ(truth.sent, said.sent);
      EXPECT_EQ(truth.lost, said.lost);
      EXPECT_EQ(truth.lost_at_start, said.lost_at_start);
      EXPECT_EQ(truth.lost_at_end, said.lost_at_end);
      EXPECT_EQ(truth.gaps, said.gaps);
      EXPECT_EQ(truth.duplicated, said.duplicated);
      EXPECT_EQ(truth.out_of_order, said.out_of_order);
      EXPECT_EQ(static_cast<std::size_t>(
                    std::count_if(arrived.begin(), arrived.end(), [&](const Arrived& a) { return a.from == from; })),
                said.received());
    }
  }
}

TEST(PacketFaults, StrikesAtTheRatesAskedForAndWithinTheWindow) {
  FaultOptions options;
  options.loss = 0.05;
  options.duplicate = 0.03;
  options.reorder = 0.02;
  options.flip = 0.01;
  options.window = 5;
  constexpr int kPackets = 60'000;
  PacketFaults used({}, 0, {});
  run(options, 3, kPackets, &used);
  const FaultCounts& counts = used.counts().at(kPoints);
  const auto near = [&](double share, std::uint64_t count) {
    const double n = kPackets * 11.0 / 12.0;
    EXPECT_NEAR(share * n, static_cast<double>(count), 5.0 * std::sqrt(share * n));
  };
  near(0.05, counts.lost);
  near(0.03, counts.duplicated);
  near(0.02, counts.out_of_order);
  near(0.01, counts.flipped);

  options = {};
  options.reorder = 0.05;
  options.window = 5;
  int furthest = 0;
  const auto arrived = run(options, 4, kPackets);
  int place = 0;
  for (const Arrived& datagram : arrived) {
    if (datagram.from != kPoints) continue;
    const auto number = static_cast<int>(datagram.number());
    furthest = std::max(furthest, place - (number - number / 12));
    ++place;
  }
  // Five by the window; others that are overtaken meanwhile move it on by a few.
  EXPECT_GE(furthest, 5);
  EXPECT_LE(furthest, 8);
}

TEST(PacketFaults, KeepsTheStampsInOrderAndDelaysNoLongerThanAskedFor) {
  FaultOptions options;
  options.reorder = 0.05;
  options.delay = 0.05;
  options.duplicate = 0.05;
  options.longest_delay_s = 0.01;
  const auto arrived = run(options, 5, 12'000);
  double longest = 0.0;
  for (std::size_t i = 0; i < arrived.size(); ++i) {
    if (i > 0) {
      ASSERT_LE(arrived[i - 1].stamp_ns, arrived[i].stamp_ns);
    }
    const std::int64_t sent = kStart + arrived[i].number() * 400'000LL;
    ASSERT_GE(arrived[i].stamp_ns, sent);
    if (arrived[i].from == kPoints) longest = std::max(longest, 1e-9 * static_cast<double>(arrived[i].stamp_ns - sent));
  }
  EXPECT_GT(longest, 0.009);
  EXPECT_LE(longest, 0.01 + 1e-9);
}

TEST(PacketFaults, FlipsOneBitOfTheDatagramsThatItSays) {
  FaultOptions options;
  options.flip = 0.1;
  PacketFaults used({}, 0, {});
  const auto arrived = run(options, 6, 5000, &used);
  const auto clean = run({}, 6, 5000);
  ASSERT_EQ(clean.size(), arrived.size());
  std::uint64_t flipped = 0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    int bits = 0;
    for (std::size_t b = 0; b < clean[i].bytes.size(); ++b)
      bits += std::popcount(static_cast<unsigned>(clean[i].bytes[b] ^ arrived[i].bytes[b]));
    EXPECT_LE(bits, 1);
    flipped += static_cast<std::uint64_t>(bits);
  }
  EXPECT_EQ(flipped, used.counts().at(kPoints).flipped + used.counts().at(kImu).flipped);
}

TEST(PacketFaults, GivesTheSameBytesForTheSameSeedAndNothingElseWithoutFaults) {
  FaultOptions options;
  options.loss = options.duplicate = options.reorder = options.delay = options.flip = 0.02;
  EXPECT_TRUE(run(options, 7, 3000) == run(options, 7, 3000));
  EXPECT_FALSE(run(options, 7, 3000) == run(options, 8, 3000));
  EXPECT_TRUE(run({}, 7, 3000) == run({}, 8, 3000));
}

TEST(PacketFaults, LetsPassWhatIsNoSamplePacketAndHandsErrorsOn) {
  FaultOptions options;
  options.loss = 0.9;
  int passed = 0;
  PacketFaults faults(options, 1, [&](const Datagram&) -> Expected<void> {
    ++passed;
    return passed > 100 ? Expected<void>(system_error("full")) : Expected<void>();
  });
  const std::vector<std::uint8_t> control{0xAA, 1};
  for (int i = 0; i < 100; ++i) EXPECT_TRUE(faults.add({kStart, kPoints, kHost, control}));
  EXPECT_EQ(passed, 100);
  EXPECT_FALSE(faults.add({kStart, kPoints, kHost, control}));
  EXPECT_TRUE(faults.counts().empty());
}

}  // namespace
}  // namespace rigcal::sim
