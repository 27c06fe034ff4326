#include "core/clocks/device_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kSecond = 1'000'000'000;
constexpr std::int64_t kSessionStart = 1'700'000'000 * kSecond;
constexpr std::int64_t kShortestWay = 150'000;  // Cable, switch and interrupt: the constant part of every delay.

struct Stream {
  double drift_ppm = 0.0;  ///< Positive: the device's clock runs fast.
  std::int64_t interval_ns = 400'000;
  double jitter_ns = 50'000.0;  ///< Mean of the exponential part of the delay.
  double bursts_per_s = 0.5;    ///< A burst holds all packets of up to 50 ms back to its end.
  bool burst_at_start = false;
  double seconds = 20.0;
  std::int64_t device_start_ns = 12 * kSecond;
};

struct Packet {
  std::int64_t true_ns = 0;
  std::int64_t device_ns = 0;
  std::int64_t received_ns = 0;
};

std::vector<Packet> make_packets(const Stream& stream, std::uint64_t seed) {
  Random random(seed);
  std::vector<Packet> packets;
  std::int64_t burst_end = stream.burst_at_start ? 50 * kMillisecond : 0;
  std::int64_t received = 0;
  const auto count = static_cast<std::int64_t>(stream.seconds * 1e9 / static_cast<double>(stream.interval_ns));
  for (std::int64_t i = 0; i < count; ++i) {
    const std::int64_t device = i * stream.interval_ns;
    const std::int64_t since = std::llround(static_cast<double>(device) / (1.0 + stream.drift_ppm * 1e-6));
    if (random.uniform() < stream.bursts_per_s * static_cast<double>(stream.interval_ns) * 1e-9) {
      burst_end = since + static_cast<std::int64_t>(random.uniform(5.0, 50.0) * 1e6);
    }
    const std::int64_t delay = kShortestWay + std::llround(-std::log(1.0 - random.uniform()) * stream.jitter_ns);
    received = std::max({received, since + delay, burst_end});  // One queue: nothing overtakes.
    packets.push_back({kSessionStart + since, stream.device_start_ns + device, kSessionStart + received});
  }
  return packets;
}

/// The largest distance in ns from the truth plus the shortest way, from `after_s` on.
double worst_error_ns(DeviceClock& clock, const std::vector<Packet>& packets, double after_s) {
  double worst = 0.0;
  for (const Packet& packet : packets) {
    const SessionStamp stamp = clock.add(packet.device_ns, packet.received_ns);
    EXPECT_FALSE(stamp.stray);
    EXPECT_FALSE(stamp.jumped);
    if (packet.true_ns < kSessionStart + static_cast<std::int64_t>(after_s * 1e9)) continue;
    worst = std::max(worst, std::abs(static_cast<double>(stamp.stamp_ns - packet.true_ns - kShortestWay)));
  }
  return worst;
}

TEST(DeviceClock, StaysNearTheTruthWithDriftJitterAndBursts) {
  double worst = 0.0;
  double worst_settled = 0.0;
  for (const double drift_ppm : {-200.0, -20.0, 0.0, 35.0, 200.0}) {
    for (std::uint64_t seed = 1; seed <= 5; ++seed) {
      for (const bool burst_at_start : {false, true}) {
        const Stream stream{.drift_ppm = drift_ppm, .burst_at_start = burst_at_start};
        const std::vector<Packet> packets = make_packets(stream, seed);
        DeviceClock clock;
        worst = std::max(worst, worst_error_ns(clock, packets, 1.0));
        DeviceClock again;
        worst_settled = std::max(worst_settled, worst_error_ns(again, packets, 5.0));
        EXPECT_NEAR(clock.figures().drift_ppm, drift_ppm, 2.0);  // 10 us of jitter over some 10 s of line.
        EXPECT_EQ(clock.figures().jumps, 0U);
      }
    }
  }
  RecordProperty("worst_after_1_s_us", std::to_string(worst * 1e-3));
  RecordProperty("worst_after_5_s_us", std::to_string(worst_settled * 1e-3));
  EXPECT_LT(worst, 0.2e6);         // The aim is 1 ms; before the drift is known, half a second of it is 100 us.
  EXPECT_LT(worst_settled, 10e3);  // A fifth of the mean jitter.
}

TEST(DeviceClock, StandsFortyTimesTheJitterAndASlowStream) {
  const Stream stream{
      .drift_ppm = 80.0, .interval_ns = 5 * kMillisecond, .jitter_ns = 2e6, .bursts_per_s = 0.0, .seconds = 60.0};
  DeviceClock clock;
  // 20 packets in a tenth of a second, delayed by 2 ms on average: the earliest is late by 0.1 ms.
  EXPECT_LT(worst_error_ns(clock, make_packets(stream, 3), 2.0), 1e6);
  EXPECT_NEAR(clock.figures().jitter_ns, 2e6, 0.2e6);
}

TEST(DeviceClock, KeepsOrderAndTheSpacingOfTheShots) {
  const Stream stream{.drift_ppm = 60.0, .bursts_per_s = 2.0, .burst_at_start = true, .seconds = 30.0};
  const std::vector<Packet> packets = make_packets(stream, 9);
  DeviceClock clock;
  SessionStamp last;
  double worst_stretch = 0.0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const SessionStamp stamp = clock.add(packets[i].device_ns, packets[i].received_ns);
    if (i > 0) {
      EXPECT_GT(stamp.stamp_ns, last.stamp_ns);
      const double stretch = static_cast<double>(stamp.stamp_ns - last.stamp_ns) / 400'000.0 - 1.0;
      if (packets[i].true_ns > kSessionStart + 2 * kSecond) worst_stretch = std::max(worst_stretch, std::abs(stretch));
    }
    last = stamp;
  }
  EXPECT_LT(worst_stretch, 1e-3);  // 10 ns on the 10 us between two shots.
}

TEST(DeviceClock, TheAnswerDoesNotDependOnWhatComesLater) {
  const std::vector<Packet> packets = make_packets({.seconds = 3.0}, 4);
  DeviceClock whole;
  std::vector<std::int64_t> stamps;
  for (const Packet& packet : packets) stamps.push_back(whole.add(packet.device_ns, packet.received_ns).stamp_ns);
  DeviceClock half;
  for (std::size_t i = 0; i < packets.size() / 2; ++i) {
    EXPECT_EQ(half.add(packets[i].device_ns, packets[i].received_ns).stamp_ns, stamps[i]);
  }
}

TEST(DeviceClock, FollowsADeviceThatStartsAnew) {
  const Stream first{.seconds = 5.0};
  std::vector<Packet> packets = make_packets(first, 1);
  const std::size_t reboot = packets.size();
  for (Packet packet : make_packets({.seconds = 5.0, .device_start_ns = 0}, 2)) {
    packet.true_ns += 8 * kSecond;
    packet.received_ns += 8 * kSecond;
    packets.push_back(packet);
  }
  DeviceClock clock;
  std::int64_t last = 0;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const SessionStamp stamp = clock.add(packets[i].device_ns, packets[i].received_ns);
    EXPECT_GT(stamp.stamp_ns, last);
    last = stamp.stamp_ns;
    EXPECT_EQ(stamp.jumped, i == reboot + 4);
    const double error = static_cast<double>(stamp.stamp_ns - packets[i].true_ns - kShortestWay);
    if (i < reboot + 2500) continue;
    EXPECT_LT(std::abs(error), 0.3e6);  // A second later, as at the first start.
  }
  EXPECT_EQ(clock.figures().jumps, 1U);
  EXPECT_EQ(clock.figures().strays, 0U);
}

TEST(DeviceClock, FollowsAClockThatIsSetForwardsOrBackwards) {
  for (const std::int64_t step : {300 * kMillisecond, -300 * kMillisecond, 5000 * kSecond, -60 * kMillisecond}) {
    std::vector<Packet> packets = make_packets({.seconds = 8.0, .device_start_ns = 10000 * kSecond}, 6);
    for (std::size_t i = packets.size() / 2; i < packets.size(); ++i) packets[i].device_ns += step;
    DeviceClock clock;
    double worst = 0.0;
    for (std::size_t i = 0; i < packets.size(); ++i) {
      const SessionStamp stamp = clock.add(packets[i].device_ns, packets[i].received_ns);
      if (i < packets.size() / 2 + 2500) continue;
      worst = std::max(worst, std::abs(static_cast<double>(stamp.stamp_ns - packets[i].true_ns - kShortestWay)));
    }
    EXPECT_EQ(clock.figures().jumps, 1U) << step;
    EXPECT_LT(worst, 0.3e6) << step;
  }
}

// Whoever asks for order, or counts gaps, has to hear of a step: packets that are late at the start, by more than can
// be mended without one but less than a stray, and later ones that come to be late for good.
TEST(DeviceClock, TellsOfEveryStep) {
  struct Late {
    double from_s, to_s;
    std::int64_t by_ns;
  };
  for (const Late& late : {Late{0.0, 0.3, 150 * kMillisecond}, Late{4.0, 12.0, 400 * kMillisecond}}) {
    std::vector<Packet> packets = make_packets({.bursts_per_s = 0.0, .seconds = 12.0}, 5);
    for (Packet& packet : packets) {
      const double since_s = 1e-9 * static_cast<double>(packet.true_ns - kSessionStart);
      if (since_s >= late.from_s && since_s < late.to_s) packet.received_ns += late.by_ns;
    }
    DeviceClock clock;
    std::int64_t last = 0;
    int told = 0;
    for (std::size_t i = 0; i < packets.size(); ++i) {
      const SessionStamp stamp = clock.add(packets[i].device_ns, packets[i].received_ns);
      ASSERT_FALSE(stamp.stray);
      const double stretch = static_cast<double>(stamp.stamp_ns - last) / 400'000.0 - 1.0;
      EXPECT_TRUE(i == 0 || stamp.jumped || std::abs(stretch) < 0.25) << "packet " << i;
      told += stamp.jumped ? 1 : 0;
      last = stamp.stamp_ns;
    }
    EXPECT_EQ(told, 1) << late.from_s;
    EXPECT_EQ(clock.figures().jumps, 1U) << late.from_s;
  }
}

TEST(DeviceClock, OneDamagedStampChangesNothing) {
  std::vector<Packet> packets = make_packets({.seconds = 4.0}, 7);
  DeviceClock clean;
  DeviceClock damaged;
  for (std::size_t i = 0; i < packets.size(); ++i) {
    const auto expected = clean.add(packets[i].device_ns, packets[i].received_ns);
    if (i % 1000 == 999) {
      for (const std::int64_t wild : {std::int64_t{0}, std::int64_t{1} << 62U, INT64_MAX, INT64_MIN}) {
        const SessionStamp stray = damaged.add(wild, packets[i].received_ns);
        EXPECT_TRUE(stray.stray);
        EXPECT_EQ(stray.stamp_ns, packets[i].received_ns);
      }
    }
    EXPECT_EQ(damaged.add(packets[i].device_ns, packets[i].received_ns).stamp_ns, expected.stamp_ns);
  }
  EXPECT_EQ(damaged.figures().jumps, 0U);
  EXPECT_EQ(damaged.figures().strays, 40U);  // Four for every 1000 of 10000 packets.
}

TEST(DeviceClock, APauseOfAMinuteIsNoJump) {
  std::vector<Packet> packets = make_packets({.drift_ppm = 100.0, .seconds = 70.0}, 8);
  DeviceClock clock;
  double worst = 0.0;
  for (const Packet& packet : packets) {
    const std::int64_t since = packet.true_ns - kSessionStart;
    if (since > 5 * kSecond && since < 65 * kSecond) continue;
    const SessionStamp stamp = clock.add(packet.device_ns, packet.received_ns);
    EXPECT_FALSE(stamp.jumped || stamp.stray);
    if (since < 66 * kSecond) continue;
    worst = std::max(worst, std::abs(static_cast<double>(stamp.stamp_ns - packet.true_ns - kShortestWay)));
  }
  EXPECT_LT(worst, 0.5e6);  // The drift is known to some ppm after five seconds; a minute of that is 0.2 ms.
}

}  // namespace
}  // namespace rigcal
