// Devices whose clocks follow nothing, pulses, pulses and the host's time of day, or PTP: all of it becomes session
// time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <map>
#include <set>
#include <thread>

#include "apps/capture/live_datagrams.h"
#include "apps/ingest/lidar_ingest.h"
#include "drivers/livox_codec/status.h"
#include "simdata/live/live_run.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

using livox::TimestampType;

constexpr std::uint16_t discovery_port = 55019;  // Not the usual one: other tests run at the same time.
constexpr std::int64_t second_ns = 1'000'000'000;

struct Heard {
  std::map<TimestampType, int> packets;
  std::map<TimestampType, std::int64_t> worst_utc_ns;  ///< Of the stamp, to when the packet came.
  std::set<int> sensors;
  std::int64_t worst_ns = 0;  ///< Between a packet's session stamp and when it came.
  std::uint64_t backward = 0;
  IngestSummary ingest;
  std::vector<livox::DeviceReport> devices;
};

struct Trial {
  sim::TimeSource source = sim::TimeSource::none;
  bool send_utc = false;
  TimestampType expected = TimestampType::since_start;
};

Heard hear(const Trial& trial) {
  Heard heard;
  auto rig = load_rig(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/loopback.yaml");
  EXPECT_TRUE(rig.has_value());
  rig->network.send_utc = trial.send_utc;
  std::erase_if(rig->sensors, [](const Sensor& sensor) { return !sensor.is_lidar(); });
  livox::DriverOptions options = *driver_options(*rig);
  options.discovery_port = discovery_port;
  options.queue_datagrams = 1U << 13U;
  auto driver = livox::Driver::start(options);
  EXPECT_TRUE(driver.has_value()) << driver.error().message();
  sim::LiveOptions live;
  live.run.seed = 4;
  live.run.turntable.stops = 1;
  live.loop = true;
  live.discovery_port = discovery_port;
  live.device.broadcast_s = 0.1;
  live.device.spin_up_s = 0.1;
  live.time_source = trial.source;
  std::stop_source stop;
  std::thread devices([&] {
    const auto scene = sim::load_scene("room");
    SilentReporter silent;
    EXPECT_TRUE(sim::serve_live(*scene, *rig, live, {silent, stop.get_token()}).has_value());
  });
  std::int64_t received_ns = 0;
  std::map<int, std::int64_t> last;
  LidarIngest ingest(*rig,
                     [&](PointBatch& batch) {
                       heard.sensors.insert(batch.sensor);
                       heard.worst_ns = std::max(heard.worst_ns, std::abs(batch.stamp_ns - received_ns));
                       if (last.contains(batch.sensor) && batch.stamp_ns <= last[batch.sensor]) ++heard.backward;
                       last[batch.sensor] = batch.stamp_ns;
                     },
                     {});
  // Until all devices have sent more than a second of what is expected; far longer on a busy machine.
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  Datagram datagram;
  while (heard.packets[trial.expected] < 7000 && std::chrono::steady_clock::now() < end) {
    if (!(*driver)->next(datagram, 50'000'000)) continue;
    received_ns = datagram.stamp_ns;
    ingest.add(datagram);
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    if (!packet) continue;
    const TimestampType type = packet->header.timestamp_type;
    ++heard.packets[type];
    const std::int64_t off = std::abs(packet->header.device_stamp_ns - received_ns);
    heard.worst_utc_ns[type] = std::max(heard.worst_utc_ns[type], off);
  }
  heard.devices = (*driver)->devices();
  stop.request_stop();
  devices.join();
  heard.ingest = ingest.summary();
  return heard;
}

class LiveTime : public testing::TestWithParam<Trial> {};

TEST_P(LiveTime, BecomesSessionTime) {
  const Trial& trial = GetParam();
  const Heard heard = hear(trial);
  EXPECT_GE(heard.packets.at(trial.expected), 7000);
  EXPECT_EQ(heard.sensors.size(), 4U);
  EXPECT_EQ(heard.backward, 0U);
  // Packets may be late on a busy machine, but no clock may be a second off.
  EXPECT_LT(heard.worst_ns, second_ns * 9 / 10);
  for (const DeviceIngest& device : heard.ingest.devices) {
    // The time of day comes once, and the clock steps to it.
    EXPECT_LE(device.clock.jumps, trial.send_utc ? 1U : 0U) << to_string(device.ip);
    EXPECT_LE(device.clock.strays, trial.send_utc ? 10U : 0U) << to_string(device.ip);
  }
  if (trial.expected == TimestampType::gps || trial.expected == TimestampType::ptp) {
    EXPECT_LT(heard.worst_utc_ns.at(trial.expected), second_ns / 2);
  }
  for (const livox::DeviceReport& device : heard.devices) {
    const livox::Status status = livox::decode_status(device.link.status);
    const bool has_pulses = trial.source == sim::TimeSource::pps;
    EXPECT_EQ(status.pps_ok, has_pulses);
    EXPECT_EQ(status.ptp_ok, trial.source == sim::TimeSource::ptp);
    EXPECT_EQ(device.link.counters.utc_taken > 0, trial.send_utc);
    EXPECT_EQ(device.link.counters.utc_refused, 0U);
  }
}

INSTANTIATE_TEST_SUITE_P(Sources, LiveTime,
                         testing::Values(Trial{sim::TimeSource::none, false, TimestampType::since_start},
                                         Trial{sim::TimeSource::pps, false, TimestampType::pps_only},
                                         Trial{sim::TimeSource::pps, true, TimestampType::gps},
                                         Trial{sim::TimeSource::ptp, false, TimestampType::ptp}));

}  // namespace
}  // namespace rigcal
