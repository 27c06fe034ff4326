// The book of packets that LidarIngest keeps, against what was really done to them.
#include <gtest/gtest.h>

#include <string>

#include "apps/ingest/lidar_findings.h"
#include "drivers/livox_codec/sample_packet.h"
#include "simdata/packets/packet_faults.h"

namespace rigcal {
namespace {

constexpr IpAddress kIp{192, 168, 1, 179};
constexpr Endpoint kPoints{kIp, 60001};
constexpr Endpoint kImu{kIp, 60003};
constexpr Endpoint kHost{{192, 168, 1, 5}, 56001};
constexpr std::int64_t kStart = 1'700'000'000'000'000'000;

Rig rig_of(LidarModel model) {
  Rig rig;
  Sensor& sensor = rig.sensors.emplace_back();
  sensor.name = "lidar";
  sensor.lidar.emplace();
  sensor.lidar->model = model;
  sensor.lidar->ip = kIp;
  return rig;
}

struct Sender {
  livox::DataType type = livox::DataType::cartesian_tagged;
  livox::TimestampType stamps = livox::TimestampType::since_start;
  std::int64_t interval_ns = 400'000;
  bool has_imu = true;
};

/// Sends `packets` packets of a device whose clock is 30 ppm fast, and the IMU's among them.
void send(const Sender& sender, std::int64_t packets, sim::PacketFaults& faults) {
  constexpr double kDrift = 30e-6;
  livox::SampleHeader header;
  header.timestamp_type = sender.stamps;
  std::vector<std::uint8_t> bytes;
  std::int64_t next_imu_ns = 0;
  // Where the stamps begin: a clock that reads as UTC, or some uptime.
  const std::int64_t begin = sender.stamps == livox::TimestampType::gps ? kStart : 77'000'000'000;
  const auto stamp_of = [&](std::int64_t device_ns) {
    return sender.stamps == livox::TimestampType::pps_only ? device_ns % 1'000'000'000 : device_ns;
  };
  const auto received = [&](std::int64_t since_ns) {
    return kStart + since_ns - static_cast<std::int64_t>(kDrift * static_cast<double>(since_ns)) + 300'000;
  };
  for (std::int64_t i = 0; i < packets; ++i) {
    const std::int64_t since = i * sender.interval_ns;
    if (sender.has_imu && since >= next_imu_ns) {
      header.data_type = livox::DataType::imu;
      header.device_stamp_ns = stamp_of(begin + next_imu_ns);
      livox::encode_imu(header, {{0.0F, 0.0F, 0.0F}, {0.0F, 0.0F, 1.0F}}, bytes);
      ASSERT_TRUE(faults.add({received(since), kImu, kHost, bytes}));
      next_imu_ns += 5'000'000;
    }
    header.data_type = sender.type;
    header.device_stamp_ns = stamp_of(begin + since);
    livox::encode_points(header, {}, bytes);
    ASSERT_TRUE(faults.add({received(since) + 1000, kPoints, kHost, bytes}));
  }
  ASSERT_TRUE(faults.flush());
}

struct Outcome {
  DeviceIngest device;
  sim::FaultCounts points;
  sim::FaultCounts imu;
};

Outcome run(const Rig& rig, const Sender& sender, const sim::FaultOptions& options, std::uint64_t seed,
            std::int64_t packets) {
  LidarIngest ingest(rig, {}, {});
  sim::PacketFaults faults(options, seed, [&](const Datagram& datagram) -> Expected<void> {
    ingest.add(datagram);
    return {};
  });
  send(sender, packets, faults);
  Outcome outcome;
  const IngestSummary summary = ingest.summary();
  EXPECT_EQ(summary.devices.size(), 1U);
  if (!summary.devices.empty()) outcome.device = summary.devices[0];
  outcome.points = faults.counts().at(kPoints);
  if (sender.has_imu) outcome.imu = faults.counts().at(kImu);
  return outcome;
}

void expect_exact(const sim::FaultCounts& truth, const StreamBook& book, const std::string& where) {
  EXPECT_EQ(book.received, truth.received()) << where;
  EXPECT_EQ(book.lost, truth.lost - truth.lost_at_start - truth.lost_at_end) << where;
  EXPECT_EQ(book.expected(), truth.sent - truth.lost_at_start - truth.lost_at_end) << where;
  EXPECT_EQ(book.duplicated, truth.duplicated) << where;
  EXPECT_EQ(book.out_of_order, truth.out_of_order) << where;
  EXPECT_EQ(book.gaps, truth.gaps) << where;
  EXPECT_EQ(book.damaged, 0U) << where;
  EXPECT_EQ(book.restarts + book.too_late, 0U) << where;
  std::uint64_t listed = 0;
  for (const StreamGap& gap : book.listed_gaps) listed += gap.lost;
  if (book.gaps <= StreamLedger::kListedGaps) {
    EXPECT_EQ(listed, book.lost) << where;
  } else {
    EXPECT_EQ(book.listed_gaps.size(), StreamLedger::kListedGaps) << where;
  }
}

TEST(PacketLedger, IsExactForEveryDataTypeAndTimestampAndLossUpToFivePercent) {
  const struct {
    livox::DataType type;
    LidarModel model;
    std::int64_t interval_ns;
  } kinds[] = {
      {livox::DataType::cartesian, LidarModel::livox_mid40, 1'000'000},
      {livox::DataType::spherical, LidarModel::livox_mid40, 1'000'000},
      {livox::DataType::cartesian_tagged, LidarModel::livox_avia, 400'000},
      {livox::DataType::cartesian_tagged, LidarModel::livox_mid70, 960'000},
      {livox::DataType::spherical_tagged, LidarModel::livox_horizon, 400'000},
      {livox::DataType::dual_cartesian, LidarModel::livox_avia, 200'000},
      {livox::DataType::dual_spherical, LidarModel::livox_tele15, 200'000},
      {livox::DataType::triple_cartesian, LidarModel::livox_avia, 125'000},
      {livox::DataType::triple_spherical, LidarModel::livox_avia, 125'000},
  };
  using livox::TimestampType;
  std::uint64_t seed = 0;
  std::uint64_t lost = 0;
  for (const auto& kind : kinds) {
    for (const auto stamps :
         {TimestampType::since_start, TimestampType::ptp, TimestampType::gps, TimestampType::pps_only}) {
      for (const double loss : {1e-4, 1e-3, 1e-2, 5e-2}) {
        sim::FaultOptions options;
        options.loss = loss;
        options.duplicate = 0.3 * loss + 1e-3;
        options.reorder = 0.5 * loss + 1e-3;
        options.delay = 0.5 * loss;
        const Sender sender{kind.type, stamps, kind.interval_ns, kind.interval_ns < 900'000};
        const Outcome outcome = run(rig_of(kind.model), sender, options, ++seed, loss < 1e-3 ? 12'000 : 5'000);
        const std::string where = "type " + std::to_string(static_cast<int>(kind.type)) + ", stamps " +
                                  std::to_string(static_cast<int>(stamps)) + ", loss " + std::to_string(loss);
        expect_exact(outcome.points, outcome.device.point_stream, where);
        if (sender.has_imu) expect_exact(outcome.imu, outcome.device.imu_stream, where + ", IMU");
        EXPECT_EQ(outcome.device.clock.jumps, 0U) << where;
        lost += outcome.points.lost;
      }
    }
  }
  EXPECT_GT(lost, 10'000U);
}

TEST(PacketLedger, IsExactForManySeedsOfHeavyFaults) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    sim::FaultOptions options;
    options.loss = 0.05;
    options.duplicate = 0.05;
    options.reorder = 0.05;
    options.delay = 0.05;
    options.window = 1 + static_cast<int>(seed % 40);
    options.longest_delay_s = 0.03;
    const Outcome outcome = run(rig_of(LidarModel::livox_avia), {}, options, seed, 4000);
    expect_exact(outcome.points, outcome.device.point_stream, "seed " + std::to_string(seed));
    expect_exact(outcome.imu, outcome.device.imu_stream, "IMU, seed " + std::to_string(seed));
  }
}

TEST(PacketLedger, CountsDamagedPacketsOfEachStream) {
  Rig rig = rig_of(LidarModel::livox_avia);
  LidarIngest ingest(rig, {}, {});
  std::uint64_t damaged_points = 0;
  std::uint64_t damaged_imu = 0;
  std::uint64_t number = 0;
  // Every 50th point packet loses its tail, every 20th IMU packet says another version.
  sim::PacketFaults faults({}, 1, [&](const Datagram& datagram) -> Expected<void> {
    std::vector<std::uint8_t> bytes(datagram.bytes.begin(), datagram.bytes.end());
    const bool inside = ++number > 100 && number < 4900;
    if (inside && datagram.from == kPoints && number % 50 == 0) {
      bytes.pop_back();
      ++damaged_points;
    } else if (inside && datagram.from == kImu && number % 20 == 0) {
      bytes[0] ^= 0x40U;
      ++damaged_imu;
    }
    ingest.add({datagram.stamp_ns, datagram.from, datagram.to, bytes});
    return {};
  });
  send({}, 5000, faults);
  const IngestSummary summary = ingest.summary();
  ASSERT_EQ(summary.devices.size(), 1U);
  const DeviceIngest& device = summary.devices[0];
  EXPECT_GT(damaged_points, 50U);
  EXPECT_GT(damaged_imu, 5U);
  EXPECT_EQ(device.point_stream.damaged, damaged_points);
  EXPECT_EQ(device.point_stream.lost, damaged_points);
  EXPECT_EQ(device.imu_stream.damaged, damaged_imu);
  EXPECT_EQ(device.imu_stream.lost, damaged_imu);
  EXPECT_EQ(device.malformed, damaged_points + damaged_imu);
  const auto counters = packet_counters(rig, summary);
  EXPECT_EQ(counters.at("lidar").at("point_damaged"), damaged_points);
  EXPECT_EQ(counters.at("lidar").at("imu_lost"), damaged_imu);
  EXPECT_EQ(counters.at("lidar").at("point_expected"), 5000U);
}

TEST(PacketLedger, StaysNearTheTruthWhereAnyBitMayBeWrong) {
  for (std::uint64_t seed = 1; seed <= 10; ++seed) {
    sim::FaultOptions options;
    options.loss = 0.01;
    options.flip = 0.02;
    const Outcome outcome = run(rig_of(LidarModel::livox_avia), {}, options, seed, 10'000);
    // A flip in the eight bytes of the stamp, of 1362, may shift one packet to another place; the others are told.
    const auto truth = static_cast<double>(outcome.points.lost);
    EXPECT_NEAR(truth, static_cast<double>(outcome.device.point_stream.lost), 10.0) << "seed " << seed;
    // A wrong stamp in the first second, when nothing is known of the clock yet, may be believed for a while.
    EXPECT_LE(outcome.device.clock.jumps, 1U);
  }
}

}  // namespace
}  // namespace rigcal
