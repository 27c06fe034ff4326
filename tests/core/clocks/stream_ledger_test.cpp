#include "core/clocks/stream_ledger.h"

#include <gtest/gtest.h>

#include <utility>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr double kInterval = 400'000.0;

/// Stamp of packet i as a device rounds it.
std::int64_t stamp(std::int64_t i) { return 5'000'000 + i * 400'000 + (i * 7919) % 64; }

TEST(StreamLedger, CountsInjectedLossDuplicatesAndReorderExactly) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    Random random(seed);
    std::vector<std::int64_t> sent;
    StreamCounters truth;
    constexpr std::int64_t kPackets = 20000;
    std::int64_t run = 0;  // Packets still to lose.
    for (std::int64_t i = 0; i < kPackets; ++i) {
      if (run == 0 && random.uniform() < 0.01) run = 1 + static_cast<std::int64_t>(random.below(50));
      // What is lost before the first and after the last packet cannot be seen.
      if (run > 0 && i > 0 && i < kPackets - 60) {
        --run;
        ++truth.lost;
        continue;
      }
      sent.push_back(i);
      ++truth.received;
      if (random.uniform() < 0.005) {
        sent.push_back(i);
        ++truth.received;
        ++truth.duplicated;
      }
    }
    for (std::size_t i = 1; i + 1 < sent.size(); ++i) {
      if (random.uniform() < 0.01 && sent[i] + 1 == sent[i + 1] && sent[i - 1] < sent[i]) {
        std::swap(sent[i], sent[i + 1]);
        ++truth.out_of_order;
        i += 3;
      }
    }
    StreamLedger ledger;
    for (const std::int64_t i : sent) ledger.add(stamp(i), kInterval, 0);
    const StreamCounters& counters = ledger.counters();
    EXPECT_EQ(counters.received, truth.received);
    EXPECT_EQ(counters.lost, truth.lost);
    EXPECT_EQ(counters.duplicated, truth.duplicated);
    EXPECT_EQ(counters.out_of_order, truth.out_of_order);
    EXPECT_EQ(counters.expected(), static_cast<std::uint64_t>(kPackets));
  }
}

TEST(StreamLedger, ListsGapsWithPlaceAndLength) {
  StreamLedger ledger;
  for (const std::int64_t i : {0, 1, 2, 6, 7, 9}) ledger.add(stamp(i), kInterval, 1000 + i);
  const auto gaps = ledger.book().listed_gaps;
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].lost, 3U);
  EXPECT_EQ(gaps[0].start_ns, 1002 + 400'000);
  EXPECT_EQ(gaps[0].length_ns, stamp(6) - stamp(2) - 400'000);
  EXPECT_EQ(gaps[1].lost, 1U);
  EXPECT_EQ(ledger.book().longest_gap.lost, 3U);
  EXPECT_EQ(ledger.book().longest_gap.start_ns, gaps[0].start_ns);
}

TEST(StreamLedger, AGapThatIsFilledLateIsNone) {
  StreamLedger ledger;
  EXPECT_EQ(ledger.add(stamp(0), kInterval, 0), Arrival::in_order);
  EXPECT_EQ(ledger.add(stamp(2), kInterval, 0), Arrival::in_order);
  EXPECT_EQ(ledger.counters().lost, 1U);
  EXPECT_EQ(ledger.add(stamp(1), kInterval, 0), Arrival::late);
  EXPECT_EQ(ledger.add(stamp(1), kInterval, 0), Arrival::duplicate);
  EXPECT_EQ(ledger.counters().lost, 0U);
  EXPECT_EQ(ledger.counters().gaps, 0U);
  EXPECT_TRUE(ledger.book().listed_gaps.empty());
}

TEST(StreamLedger, AGapThatIsHalfFilledIsTwo) {
  StreamLedger ledger;
  for (const std::int64_t i : {0, 6, 3}) ledger.add(stamp(i), kInterval, 1000 * i);
  const auto gaps = ledger.book().listed_gaps;
  ASSERT_EQ(gaps.size(), 2U);
  EXPECT_EQ(gaps[0].lost, 2U);
  EXPECT_EQ(gaps[1].lost, 2U);
  EXPECT_EQ(gaps[1].start_ns, 3000 + 400'000);
  EXPECT_EQ(ledger.counters().gaps, 2U);
  EXPECT_EQ(ledger.counters().lost, 4U);
}

TEST(StreamLedger, CountsWhatIsMissingAfterAFirstPacketThatCameLate) {
  StreamLedger ledger;
  for (const std::int64_t i : {3, 0, 4}) ledger.add(stamp(i), kInterval, 0);
  EXPECT_EQ(ledger.counters().lost, 2U);
  EXPECT_EQ(ledger.counters().out_of_order, 1U);
  EXPECT_EQ(ledger.counters().expected(), 5U);
}

TEST(StreamLedger, KnowsDuplicatesAndLateOnesAsFarBackAsItSaysAndNoFurther) {
  constexpr auto kOpen = static_cast<std::int64_t>(StreamLedger::kOpen);
  StreamLedger ledger;
  for (std::int64_t i = 0; i < 2 * kOpen; ++i) {
    if (i != kOpen + 5) ledger.add(stamp(i), kInterval, 0);
  }
  EXPECT_EQ(ledger.add(stamp(kOpen + 4), kInterval, 0), Arrival::duplicate);
  EXPECT_EQ(ledger.add(stamp(kOpen + 5), kInterval, 0), Arrival::late);
  EXPECT_EQ(ledger.counters().lost, 0U);
  EXPECT_EQ(ledger.add(stamp(kOpen - 5), kInterval, 0), Arrival::late);
  EXPECT_EQ(ledger.counters().too_late, 1U);
  EXPECT_EQ(ledger.counters().expected(), static_cast<std::uint64_t>(2 * kOpen));
}

TEST(StreamLedger, IsSafeForStampsFromEndToEnd) {
  StreamLedger ledger;
  ledger.add(INT64_MAX, kInterval, 0);
  ledger.add(INT64_MIN, kInterval, 0);
  ledger.add(0, 1.0, 0);
  EXPECT_EQ(ledger.book().listed_gaps.size(), 2U);
  EXPECT_GT(ledger.book().longest_gap.length_ns, 0);
}

TEST(StreamLedger, AnIntervalThatChangesMakesNoGap) {
  StreamLedger ledger;
  ledger.add(0, 125'000.0, 0);
  ledger.add(125'000, 400'000.0, 0);  // From triple to single return.
  ledger.add(525'000, 400'000.0, 0);
  ledger.add(925'000, 400'000.0, 0);
  EXPECT_EQ(ledger.counters().lost, 0U);
}

TEST(StreamLedger, NothingIsLostAcrossARestart) {
  StreamLedger ledger;
  ledger.add(stamp(100000), kInterval, 0);
  ledger.restart();
  ledger.add(stamp(0), kInterval, 0);
  ledger.add(stamp(1), kInterval, 0);
  EXPECT_EQ(ledger.counters().lost, 0U);
  EXPECT_EQ(ledger.counters().out_of_order, 0U);
  EXPECT_EQ(ledger.counters().restarts, 1U);
}

TEST(StreamLedger, ListsNoMoreGapsThanItSaysButCountsAll) {
  StreamLedger ledger;
  for (std::int64_t i = 0; i < 3000; ++i) ledger.add(stamp(2 * i), kInterval, 0);
  EXPECT_EQ(ledger.book().listed_gaps.size(), StreamLedger::kListedGaps);
  EXPECT_EQ(ledger.counters().gaps, 2999U);
  EXPECT_EQ(ledger.counters().lost, 2999U);
}

}  // namespace
}  // namespace rigcal
