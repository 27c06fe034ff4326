#include "simdata/packets/run_stream.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>

#include "core/base/parallel.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::sim {
namespace {

RunOptions short_run(std::uint64_t seed) {
  RunOptions options;
  options.seed = seed;
  options.turntable.stops = 2;
  options.turntable.dwell_s = 0.3;
  options.turntable.initial_still_s = 0.2;
  options.turntable.final_still_s = 0.1;
  options.turntable.turn_s = 0.5;
  return options;
}

struct Recorded {
  std::int64_t stamp_ns = 0;
  Endpoint from;
  Endpoint to;
  std::vector<std::uint8_t> bytes;
  bool operator==(const Recorded&) const = default;
};

struct Recording {
  RunTruth truth;
  std::vector<Recorded> datagrams;
};

Recording record(const RunOptions& options, const Rig& rig = nominal_rig(), const std::string& scene_name = "room") {
  const auto scene = load_scene(scene_name);
  SilentReporter silent;
  Recording recording;
  const auto sink = [&](const Datagram& datagram) -> Expected<void> {
    recording.datagrams.push_back(
        {datagram.stamp_ns, datagram.from, datagram.to, {datagram.bytes.begin(), datagram.bytes.end()}});
    return {};
  };
  auto truth = simulate_run(*scene, rig, options, sink, {silent});
  EXPECT_TRUE(truth.has_value()) << (truth ? "" : truth.error().message());
  if (truth) recording.truth = *std::move(truth);
  return recording;
}

Rig rig_of_all_models() {
  Rig rig = nominal_rig();
  rig.sensors[1].lidar->model = LidarModel::livox_mid70;
  rig.sensors[2].lidar->model = LidarModel::livox_horizon;
  rig.sensors[3].lidar->model = LidarModel::livox_tele15;
  for (Sensor& sensor : rig.sensors) sensor.lidar->broadcast_code.clear();
  return rig;
}

TEST(RunStream, EveryModelSendsWhatItsOwnDataSheetSays) {
  const Rig rig = rig_of_all_models();
  const Recording run = record(short_run(6), rig);
  std::map<int, std::map<livox::DataType, int>> packets;
  std::map<int, std::vector<std::int64_t>> stamps;
  for (const Recorded& datagram : run.datagrams) {
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    if (!packet) continue;
    ++packets[datagram.from.ip[3]][packet->header.data_type];
    if (packet->header.data_type != livox::DataType::imu)
      stamps[datagram.from.ip[3]].push_back(packet->header.device_stamp_ns);
  }
  const auto interval_ns = [&stamps](int device) { return stamps[device][1] - stamps[device][0]; };
  for (const int device : {179, 91, 161}) {  // AVIA, HORIZON, TELE-15
    EXPECT_EQ(packets[device].size(), 2U) << device;
    EXPECT_GT(packets[device][livox::DataType::imu], 100) << device;
    EXPECT_EQ(interval_ns(device), 400'000) << device;
  }
  EXPECT_EQ(packets[21].size(), 1U);  // A MID-70 has no inertial unit.
  EXPECT_GT(packets[21][livox::DataType::cartesian_tagged], 500);
  EXPECT_EQ(interval_ns(21), 960'000);
  EXPECT_EQ(run.truth.devices[1].broadcast.broadcast_code, "3GGDSIM00000011");
  EXPECT_EQ(run.truth.devices[2].broadcast.type, livox::DeviceType::horizon);
  EXPECT_EQ(run.truth.devices[3].broadcast.type, livox::DeviceType::tele15);
}

TEST(RunStream, RefusesWhatNoModelCan) {
  for (const auto& [model, mode] :
       {std::pair{LidarModel::livox_mid70, ReturnMode::triple}, std::pair{LidarModel::livox_mid40, ReturnMode::dual},
        std::pair{LidarModel::other, ReturnMode::first}}) {
    Rig rig = nominal_rig();
    rig.sensors[1].lidar->model = model;
    rig.sensors[1].lidar->return_mode = mode;
    const auto devices = make_devices(rig, 1);
    ASSERT_FALSE(devices.has_value());
    EXPECT_NE(devices.error().where.find("mid100_left"), std::string::npos);
  }
}

TEST(RunStream, ClocksDriftAndPacketsJitterAsMuchAsAskedFor) {
  RunOptions options = short_run(6);
  options.clock_drift_ppm = 400.0;
  options.path.jitter_s = 5e-3;
  const Recording run = record(options);
  double widest_ppm = 0.0;
  for (const SimDevice& device : run.truth.devices)
    widest_ppm = std::max(widest_ppm, std::abs(device.clock.drift) * 1e6);
  EXPECT_GT(widest_ppm, 50.0);
  EXPECT_LE(widest_ppm, 400.0);
  // Packets stay in order, so that a late one holds back those behind it; none is early.
  double late_s = 0.0;
  int packets = 0;
  for (const Recorded& datagram : run.datagrams) {
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    if (!packet || packet->header.data_type == livox::DataType::imu || datagram.from.ip[3] != 21) continue;
    const SimDevice& device = run.truth.devices[1];
    const double end_s = device.clock.true_s(packet->header.device_stamp_ns + device.packet_interval_ns);
    late_s += static_cast<double>(datagram.stamp_ns - run.truth.sampling_ns) * 1e-9 - end_s;
    ++packets;
  }
  EXPECT_GT(late_s / packets, 5e-3);
}

TEST(RunStream, GivesTheSameBytesForAnyNumberOfThreads) {
  set_thread_count(1);
  const Recording one = record(short_run(5));
  set_thread_count(4);
  const Recording four = record(short_run(5));
  set_thread_count(2);
  EXPECT_TRUE(one.datagrams == four.datagrams);
  EXPECT_FALSE(one.datagrams == record(short_run(6)).datagrams);
}

TEST(RunStream, HandsDatagramsOnInTheOrderOfTheHostsStamps) {
  const Recording recording = record(short_run(1));
  for (std::size_t i = 1; i < recording.datagrams.size(); ++i)
    ASSERT_LE(recording.datagrams[i - 1].stamp_ns, recording.datagrams[i].stamp_ns);
}

TEST(RunStream, SendsPacketsAtTheRatesOfTheDevices) {
  const Recording recording = record(short_run(2));
  std::map<Endpoint, int> packets;
  for (const Recorded& datagram : recording.datagrams) ++packets[datagram.from];
  const double seconds = 1.4;  // 0.2 + 2 x 0.3 + 0.1 still, 0.5 turning
  ASSERT_NEAR(seconds, static_cast<double>(recording.truth.end_ns - recording.truth.sampling_ns) * 1e-9, 1e-6);
  const auto count = [&](std::uint8_t last, std::uint16_t port) { return packets[{{192, 168, 1, last}, port}]; };
  // Clocks are up to 50 ppm off: less than a packet in 1.4 s.
  EXPECT_NEAR(2500 * seconds, count(179, 60001), 1);
  EXPECT_NEAR(200 * seconds, count(179, 60003), 1);
  EXPECT_NEAR(1000 * seconds, count(21, 60001), 1);
  EXPECT_NEAR(1000 * seconds, count(161, 60001), 1);
  EXPECT_EQ(2, count(91, 65000));
}

TEST(RunStream, StampsPacketsWithoutAGapAndNearTheirTrueTime) {
  const Recording recording = record(short_run(3));
  std::map<Endpoint, std::int64_t> last;
  for (const Recorded& datagram : recording.datagrams) {
    if (datagram.from.port != livox::kPointSourcePort) continue;
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    ASSERT_TRUE(packet.has_value());
    const auto device = std::find_if(recording.truth.devices.begin(), recording.truth.devices.end(),
                                     [&](const SimDevice& d) { return d.point_source == datagram.from; });
    const std::int64_t stamp = packet->header.device_stamp_ns;
    if (last.count(datagram.from) > 0) {
      EXPECT_EQ(device->packet_interval_ns, stamp - last[datagram.from]);
    }
    last[datagram.from] = stamp;
    const double sent_s = static_cast<double>(recording.truth.sampling_ns) * 1e-9 +
                          device->clock.true_s(stamp + device->packet_interval_ns);
    const double delay_s = static_cast<double>(datagram.stamp_ns) * 1e-9 - sent_s;
    // Double seconds since 1970 resolve 0.24 us; the longest of 6000 exponential delays of 50 us on average.
    EXPECT_GT(delay_s, 0.2e-3 - 1e-6);
    EXPECT_LT(delay_s, 2e-3);
  }
}

TEST(RunStream, LosesTheShareOfPacketsAskedFor) {
  RunOptions options = short_run(4);
  options.faults.loss = 0.1;
  const double whole = static_cast<double>(record(short_run(4)).datagrams.size());
  const double kept = static_cast<double>(record(options).datagrams.size());
  // 8000 packets: five sigma of the share are 1.7 %.
  EXPECT_NEAR(0.9, kept / whole, 0.017);
  options.faults.duplicate = 0.1;
  const Recording recording = record(options);
  std::map<Endpoint, std::uint64_t> packets;
  for (const Recorded& datagram : recording.datagrams) ++packets[datagram.from];
  for (std::size_t i = 0; i < recording.truth.devices.size(); ++i) {
    const SimDevice& device = recording.truth.devices[i];
    EXPECT_EQ(recording.truth.point_packets[i].received(), packets[device.point_source]);
    EXPECT_EQ(recording.truth.imu_packets[i].received(), packets[device.imu_source]);
  }
}

TEST(RunStream, SendsTheDataTypeThatTheRigFileAsksFor) {
  Rig rig = nominal_rig();
  rig.sensors[0].lidar->return_mode = ReturnMode::dual;
  rig.sensors[1].lidar->coordinates = CoordinateSystem::spherical;
  const Recording recording = record(short_run(5), rig, "courtyard");
  std::map<std::pair<std::uint8_t, int>, int> types;
  std::size_t second_echoes = 0;
  std::vector<Point> points;
  for (const Recorded& datagram : recording.datagrams) {
    if (datagram.from.port != livox::kPointSourcePort) continue;
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    ASSERT_TRUE(packet.has_value());
    ++types[{datagram.from.ip[3], static_cast<int>(packet->header.data_type)}];
    livox::decode_points(*packet, points);
    for (const Point& point : points) second_echoes += livox::decode_tag(point.tag).return_number == 2 ? 1 : 0;
  }
  EXPECT_EQ(7000, (types[{179, static_cast<int>(livox::DataType::dual_cartesian)}]));
  EXPECT_EQ(1400, (types[{21, static_cast<int>(livox::DataType::spherical)}]));
  EXPECT_EQ(1400, (types[{91, static_cast<int>(livox::DataType::cartesian)}]));
  EXPECT_GT(second_echoes, 100U);
}

TEST(RunStream, SendsEveryDataTypeWithItsEchoesInOrder) {
  const struct {
    ReturnMode mode;
    CoordinateSystem coordinates;
    livox::DataType type;
    std::size_t most;
  } kinds[] = {
      {ReturnMode::first, CoordinateSystem::spherical, livox::DataType::spherical_tagged, 1},
      {ReturnMode::dual, CoordinateSystem::spherical, livox::DataType::dual_spherical, 2},
      {ReturnMode::triple, CoordinateSystem::cartesian, livox::DataType::triple_cartesian, 3},
      {ReturnMode::triple, CoordinateSystem::spherical, livox::DataType::triple_spherical, 3},
  };
  for (const auto& kind : kinds) {
    Rig rig = nominal_rig();
    rig.sensors.resize(1);
    rig.sensors[0].lidar->return_mode = kind.mode;
    rig.sensors[0].lidar->coordinates = kind.coordinates;
    RunOptions options = short_run(6);
    options.unit_errors.footprint_share = 1.0;
    const Recording recording = record(options, rig, "courtyard");
    std::vector<Point> points;
    std::size_t packets = 0;
    std::size_t most = 0;
    std::size_t of_one_shot = 0;
    for (const Recorded& datagram : recording.datagrams) {
      if (datagram.from.port != livox::kPointSourcePort) continue;
      const auto packet = livox::parse_sample_packet(datagram.bytes);
      ASSERT_TRUE(packet.has_value());
      ASSERT_EQ(kind.type, packet->header.data_type);
      ++packets;
      livox::decode_points(*packet, points);
      for (std::size_t i = 0; i < points.size(); ++i) {
        of_one_shot = i > 0 && points[i].shot == points[i - 1].shot ? of_one_shot + 1 : 1;
        most = std::max(most, of_one_shot);
        ASSERT_EQ(of_one_shot, livox::decode_tag(points[i].tag).return_number);
        if (of_one_shot == 1) continue;
        const Vector3d near(points[i - 1].x, points[i - 1].y, points[i - 1].z);
        ASSERT_GT(Vector3d(points[i].x, points[i].y, points[i].z).norm(), near.norm());
      }
    }
    EXPECT_EQ(kind.most, most);
    const double interval_s = 1e-9 * static_cast<double>(recording.truth.devices[0].packet_interval_ns);
    EXPECT_NEAR(1.4 / interval_s, static_cast<double>(packets), 1.5);
  }
}

TEST(RunStream, RefusesARigWithoutAddresses) {
  Rig rig = nominal_rig();
  rig.sensors[2].lidar->ip.reset();
  const auto scene = load_scene("room");
  SilentReporter silent;
  const auto truth =
      simulate_run(*scene, rig, short_run(1), [](const Datagram&) { return Expected<void>(); }, {silent});
  ASSERT_FALSE(truth.has_value());
  EXPECT_NE(std::string::npos, truth.error().message().find("mid100_middle"));
}

TEST(RunStream, EndsWithTheErrorOfTheSink) {
  const auto scene = load_scene("room");
  SilentReporter silent;
  const auto full = [](const Datagram&) -> Expected<void> { return system_error("the disk is full"); };
  const auto truth = simulate_run(*scene, nominal_rig(), short_run(1), full, {silent});
  ASSERT_FALSE(truth.has_value());
  EXPECT_EQ("the disk is full", truth.error().what);
}

}  // namespace
}  // namespace rigcal::sim
