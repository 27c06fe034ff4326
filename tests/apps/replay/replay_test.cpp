// Recordings onto the network again: as plain packets, and as devices that our own driver takes.
#include "apps/replay/replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "apps/capture/live_datagrams.h"
#include "apps/evaluation/known_rig.h"
#include "core/io/session_folder.h"
#include "drivers/livox_codec/sample_packet.h"
#include "drivers/net/waiter.h"
#include "simdata/scene/scene_file.h"
#include "simdata/session/session_writer.h"
#include "tests/support/json.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

// Other tests run at the same time: these devices have codes, a network and a port of discovery of their own.
constexpr std::uint16_t discovery_port = 55027;
constexpr livox::Ipv4 network{127, 7, 27, 0};

Rig own_rig() {
  auto rig = load_rig(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/loopback.yaml");
  EXPECT_TRUE(rig.has_value());
  for (Sensor& sensor : rig->sensors)
    if (sensor.is_lidar()) sensor.lidar->broadcast_code.replace(4, 3, "REP");
  return *std::move(rig);
}

using Bytes = std::vector<std::uint8_t>;
using Streams = std::map<std::uint8_t, std::vector<Bytes>>;  ///< By the last number of the address.

// The sample packets in a file; points and IMU of a device as they came.
Streams samples_of(const std::string& path) {
  Streams streams;
  auto file = open_datagrams(path);
  EXPECT_TRUE(file.has_value());
  Datagram datagram;
  while (file && *(*file)->next(datagram)) {
    if (livox::parse_sample_packet(datagram.bytes))
      streams[datagram.from.ip[3]].push_back({datagram.bytes.begin(), datagram.bytes.end()});
  }
  return streams;
}

std::size_t packets_of(const Streams& streams) {
  std::size_t count = 0;
  for (const auto& [device, packets] : streams) count += packets.size();
  return count;
}

// Every packet that came is one of the recording's, byte for byte and in their order. On a busy machine the kernel may
// drop some; it counts them.
void expect_in_order(const Streams& recorded, const Streams& played, std::uint64_t dropped) {
  EXPECT_EQ(packets_of(played) + dropped, packets_of(recorded));
  for (const auto& [device, packets] : played) {
    ASSERT_TRUE(recorded.contains(device));
    const std::vector<Bytes>& all = recorded.at(device);
    auto at = all.begin();
    for (const Bytes& packet : packets) {
      at = std::find(at, all.end(), packet);
      ASSERT_TRUE(at != all.end()) << "a packet that was not recorded, or out of order, of device " << int{device};
      ++at;
    }
  }
}

class Replay : public testing::Test {
 protected:
  // A second of the room; whoever needs more makes its own.
  static void SetUpTestSuite() {
    sim::RunOptions run;
    run.seed = 8;
    run.turntable.stops = 1;
    run.turntable.dwell_s = 0.3;
    run.turntable.initial_still_s = 0.2;
    run.turntable.turn_s = 0.3;
    run.turntable.final_still_s = 0.1;
    make_session("room", run, room = (scratch_folder("replay") / "session").string());
  }
  static void make_session(const std::string& scene_name, const sim::RunOptions& run, const std::string& folder) {
    const auto scene = sim::load_scene(scene_name);
    SilentReporter silent;
    const auto made = sim::simulate_session(*scene, own_rig(), run, folder, {silent});
    ASSERT_TRUE(made.has_value()) << made.error().message();
  }

  // Plays the session as devices and records them with the driver.
  Streams play_to_driver(ReplayOptions options, std::optional<ReplaySummary>& summary) {
    options.input = session;
    options.as_devices = true;
    options.network = network;
    options.discovery_port = discovery_port;
    options.spin_up_s = 0.1;
    livox::DriverOptions wanted = *driver_options(rig);
    wanted.discovery_port = discovery_port;
    wanted.queue_datagrams = 1U << 13U;
    auto driver = livox::Driver::start(wanted);
    EXPECT_TRUE(driver.has_value()) << driver.error().message();
    std::stop_source stop;
    std::thread devices([&] {
      SilentReporter silent;
      auto played = replay(options, {silent});
      EXPECT_TRUE(played.has_value()) << (played ? "" : played.error().message());
      if (played) summary = *std::move(played);
      stop.request_stop();
    });
    const std::string path = (scratch / "recorded.pcapng").string();
    auto recorder = PcapngWriter::create(path);
    LiveDatagrams live(**driver, &*recorder, stop.get_token());
    Datagram datagram;
    while (*live.next(datagram)) {
    }
    devices.join();
    EXPECT_TRUE(recorder->close().has_value());
    const auto interfaces = (*driver)->interfaces();
    dropped = interfaces[0].counters.dropped_by_kernel + interfaces[0].counters.dropped_by_queue;
    return samples_of(path);
  }

  ProgramRun program(const std::string& arguments, const std::string& before = "") {
    return run_program(before + "'" + RIGCAL_PROGRAM + "' replay " + arguments, scratch);
  }
  /// The session's packets as if all had been sent there.
  [[nodiscard]] std::string packets_to(const Endpoint& receiver) const {
    const std::string path = (scratch / ("to_" + to_string(receiver.ip) + ".pcapng")).string();
    auto file = open_datagrams(packets());
    auto writer = PcapngWriter::create(path);
    Datagram datagram;
    while (*(*file)->next(datagram)) {
      datagram.to = receiver;
      EXPECT_TRUE(writer->write(datagram).has_value());
    }
    EXPECT_TRUE(writer->close().has_value());
    return path;
  }
  [[nodiscard]] std::string packets() const { return session_packets_path(session); }

  static inline std::string room;
  const std::filesystem::path scratch = scratch_folder("replay");
  std::string session = room;
  std::uint64_t dropped = 0;  ///< By the kernel or the driver.
  const Rig rig = own_rig();
};

TEST_F(Replay, AsDevicesGivesTheSameBytesToTheDriver) {
  std::optional<ReplaySummary> summary;
  const Streams played = play_to_driver({}, summary);
  ASSERT_TRUE(summary.has_value());
  EXPECT_TRUE(summary->is_complete);
  EXPECT_EQ(summary->passes, 1);
  ASSERT_EQ(summary->devices.size(), 4U);
  const Streams recorded = samples_of(packets());
  EXPECT_EQ(summary->datagrams, packets_of(recorded));
  ASSERT_EQ(summary->unsent, 0U);
  expect_in_order(recorded, played, dropped);
  for (const ReplayedDevice& device : summary->devices) {
    EXPECT_EQ(device.not_wanted, 0U);
    EXPECT_EQ(device.ip[2], network[2]);
  }
}

// Receive stamps of the second recording are of another network, so that the devices' clocks are mapped to session time
// a little otherwise, and a stop may begin or end a packet earlier or later. The points are the same bytes.
TEST_F(Replay, WhatWasPlayedCalibratesToTheSame) {
  sim::RunOptions run = hurried_run(8, 1.1);
  run.mount_error = {0.05, 2.0};
  session = (scratch / "session").string();
  make_session("courtyard", run, session);
  std::optional<ReplaySummary> summary;
  play_to_driver({}, summary);
  ASSERT_TRUE(summary && summary->is_complete);
  const std::string rig_path = session + "/rig.yaml";
  const auto calibrate = [&](const std::string& input, const std::string& name) {
    const std::string result = (scratch / name).string();
    const ProgramRun said =
        run_rigcal("calibrate '" + input + "' --rig '" + rig_path + "' --stages joint --out '" + result + "'", scratch);
    EXPECT_LE(said.code, 1) << said.err;
    return load_result(result);
  };
  const auto recorded = calibrate(session, "recorded-result");
  const auto played = calibrate((scratch / "recorded.pcapng").string(), "played-result");
  ASSERT_TRUE(recorded.has_value() && played.has_value());
  ASSERT_EQ(recorded->sensors.size(), played->sensors.size());
  for (std::size_t i = 0; i < recorded->sensors.size(); ++i) {
    const KnownRig::Entry& one = recorded->sensors[i];
    const KnownRig::Entry& other = played->sensors[i];
    ASSERT_EQ(one.name, other.name);
    ASSERT_TRUE(one.T_base_sensor && other.T_base_sensor) << one.name;
    const SE3 difference = one.T_base_sensor->inverse() * *other.T_base_sensor;
    const double turn_deg = to_deg(log_so3(difference.R).norm());
    RecordProperty(one.name, std::to_string(1e3 * difference.t.norm()) + " mm, " + std::to_string(turn_deg) + " deg");
    EXPECT_LT(difference.t.norm(), 1e-3) << one.name;
    EXPECT_LT(turn_deg, 0.01) << one.name;
  }
}

TEST_F(Replay, AsDevicesFasterTwiceAndInOtherCoordinates) {
  ReplayOptions options;
  options.speed = 2.0;
  options.loop = true;
  SilentReporter silent;
  // The owner wants spherical coordinates of what was recorded as Cartesian.
  Rig spherical = rig;
  for (Sensor& sensor : spherical.sensors)
    if (sensor.is_lidar()) sensor.lidar->coordinates = CoordinateSystem::spherical;
  options.input = session;
  options.as_devices = true;
  options.network = network;
  options.discovery_port = discovery_port;
  options.spin_up_s = 0.1;
  livox::DriverOptions wanted = *driver_options(spherical);
  wanted.discovery_port = discovery_port;
  auto driver = livox::Driver::start(wanted);
  ASSERT_TRUE(driver.has_value());
  std::stop_source stop;
  std::optional<ReplaySummary> summary;
  std::thread devices([&] {
    auto played = replay(options, {silent, stop.get_token()});
    EXPECT_TRUE(played.has_value());
    if (played) summary = *std::move(played);
  });
  std::map<std::uint8_t, std::int64_t> last;
  std::map<std::uint8_t, std::int64_t> first;
  std::size_t wrong = 0;
  std::size_t backward = 0;
  Datagram datagram;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(20);
  // One and a half seconds of their clocks are more than a pass of 0.9 s at double speed.
  const auto is_enough = [&] {
    return last.size() == 4 && std::all_of(last.begin(), last.end(), [&](const auto& entry) {
             return entry.second - first[entry.first] > 1'500'000'000;
           });
  };
  while (!is_enough() && std::chrono::steady_clock::now() < end) {
    if (!(*driver)->next(datagram, 50'000'000)) continue;
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    if (!packet || packet->header.data_type == livox::DataType::imu) continue;
    if (!livox::record_layout(packet->header.data_type).spherical) ++wrong;
    const std::int64_t stamp = packet->header.device_stamp_ns;
    const std::uint8_t device = datagram.from.ip[3];
    first.try_emplace(device, stamp);
    if (last.contains(device) && stamp <= last[device]) ++backward;
    last[device] = stamp;
  }
  EXPECT_TRUE(is_enough());
  EXPECT_EQ(wrong, 0U);
  EXPECT_EQ(backward, 0U);
  stop.request_stop();
  devices.join();
  ASSERT_TRUE(summary.has_value());
  EXPECT_FALSE(summary->is_complete);
  EXPECT_GE(summary->passes, 1);
}

TEST_F(Replay, PlainPacketsArriveByteForByteFromEachDevicesAddress) {
  auto sink = net::UdpSocket::open({{{127, 0, 0, 1}, 0}, false, false, 8U << 20U, {}});
  ASSERT_TRUE(sink.has_value());
  auto waiter = net::Waiter::create({sink->descriptor()});
  ReplayOptions options;
  options.input = packets();
  options.to = {127, 0, 0, 1};
  options.to_port = sink->local().port;
  options.network = network;
  std::optional<ReplaySummary> summary;
  std::atomic<bool> is_over{false};
  std::thread sender([&] {
    SilentReporter silent;
    auto played = replay(options, {silent});
    EXPECT_TRUE(played.has_value()) << (played ? "" : played.error().message());
    if (played) summary = *std::move(played);
    is_over = true;
  });
  Streams received;
  std::size_t others = 0;
  net::ReceiveBatch batch(64);
  const Streams recorded = samples_of(packets());
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(15);
  // Until all are there, or a second after the last.
  while (packets_of(received) < packets_of(recorded) && std::chrono::steady_clock::now() < end) {
    if (!waiter->wait(1'000'000'000) && is_over) break;
    while (*sink->receive(batch) > 0) {
      for (std::size_t i = 0; i < batch.size(); ++i) {
        if (!livox::parse_sample_packet(batch[i].bytes)) {
          ++others;
          continue;
        }
        EXPECT_EQ(batch[i].from.ip[2], network[2]);
        received[batch[i].from.ip[3]].push_back({batch[i].bytes.begin(), batch[i].bytes.end()});
      }
    }
  }
  sender.join();
  ASSERT_TRUE(summary.has_value());
  EXPECT_TRUE(summary->is_complete);
  EXPECT_EQ(summary->datagrams, packets_of(recorded) + 8);  // Two broadcasts of each device.
  EXPECT_LE(others, 8U);
  EXPECT_EQ(received.size(), 4U);
  expect_in_order(recorded, received, packets_of(recorded) - packets_of(received));
}

TEST_F(Replay, TheProgramSaysWhatItSent) {
  const ProgramRun run = program("'" + session + "' --to 127.0.0.1:9 --network 127.7.28.0 --speed 2 --json");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto summary = parse_json(run.out);
  EXPECT_TRUE(fits_schema("replay.json", summary));
  EXPECT_EQ(summary["complete"], true);
  EXPECT_EQ(summary["devices"].size(), 4U);
  EXPECT_EQ(summary["datagrams"].get<std::size_t>(), packets_of(samples_of(packets())) + 8);
  const ProgramRun words = program("'" + session + "' --to 127.0.0.1:9 --network 127.7.28.0 --speed 5");
  EXPECT_THAT(words.out, HasSubstr("Avia 3JEDREP"));
}

TEST_F(Replay, WithoutAReceiverPacketsGoToTheRecordedHost) {
  constexpr livox::Ipv4 host{127, 7, 31, 200};
  auto sink = net::UdpSocket::open({{host, 0}, false, false, 0, {}});
  ASSERT_TRUE(sink.has_value()) << sink.error().message();
  const std::string dump = packets_to({host, sink->local().port});
  const ProgramRun run = program("'" + dump + "' --network 127.7.31.0 --speed 5 --json");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.err, HasSubstr("to 127.7.31.200, as recorded"));
  EXPECT_EQ(parse_json(run.out)["unsent"], 0);
  net::ReceiveBatch batch(64);
  EXPECT_GT(*sink->receive(batch), 0);

  const ProgramRun to_all = program("'" + packets_to({{255, 255, 255, 255}, 55100}) + "' --network 127.7.31.0");
  EXPECT_EQ(to_all.code, 3);
  EXPECT_THAT(to_all.err, HasSubstr("does not tell to which host the LiDARs sent; say where to send by --to ADDRESS"));
}

TEST_F(Replay, OfSeveralRecordedHostsOnlyThisMachineIsTaken) {
  const livox::Ipv4 one{192, 168, 1, 5};
  const livox::Ipv4 other{192, 168, 1, 6};
  EXPECT_EQ(*recorded_host({one}, {}), one);
  EXPECT_EQ(*recorded_host({one, other}, {other, {127, 0, 0, 1}}), other);
  EXPECT_FALSE(recorded_host({}, {one}));
  EXPECT_FALSE(recorded_host({one, other}, {one, other}));
  const auto neither = recorded_host({one, other}, {});
  ASSERT_FALSE(neither);
  EXPECT_THAT(neither.error().what, HasSubstr("192.168.1.5, 192.168.1.6"));
}

TEST_F(Replay, TheProgramEndsWhenItIsStopped) {
  const ProgramRun run = program("'" + session + "' --as-devices --network 127.7.29.0 --json",
                                 "timeout --foreground --preserve-status -s INT 1 ");
  ASSERT_EQ(run.code, 0) << run.err;
  const auto summary = parse_json(run.out);
  EXPECT_TRUE(fits_schema("replay.json", summary));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_EQ(summary["datagrams"], 0);  // Nobody asked for any.
}

TEST_F(Replay, TheProgramRefusesWhatCannotBePlayed) {
  std::ofstream(scratch / "run.lvx") << "livox_tech, whose recordings tell no addresses";
  EXPECT_EQ(program("'" + (scratch / "run.lvx").string() + "'").code, 2);
  EXPECT_EQ(program("'" + session + "' --to nowhere").code, 2);
  EXPECT_EQ(program("'" + session + "' --to 127.0.0.1 --as-devices").code, 2);
  EXPECT_EQ(program("'" + session + "' --as-devices --network 127.0.0.1").code, 2);
  EXPECT_EQ(program("nothing.pcap --to 127.0.0.1").code, 3);
  const std::string other = (scratch / "other.pcapng").string();
  {
    auto writer = PcapngWriter::create(other);
    const std::vector<std::uint8_t> bytes(60, 7);
    ASSERT_TRUE(writer->write({1, {{10, 0, 0, 1}, 53}, {{10, 0, 0, 2}, 53}, bytes}).has_value());
    ASSERT_TRUE(writer->close().has_value());
  }
  const ProgramRun none = program("'" + other + "' --to 127.0.0.1");
  EXPECT_EQ(none.code, 3);
  EXPECT_THAT(none.err, HasSubstr("no points of a Livox LiDAR"));
  // Nobody has addresses of this network, which is for documentation.
  const ProgramRun away = program("'" + session + "' --as-devices --network 203.0.113.0");
  EXPECT_EQ(away.code, 4);
  EXPECT_THAT(away.err, HasSubstr("sudo ip addr add"));
}

TEST_F(Replay, ACutRecordingIsPlayedAsFarAsItGoes) {
  const std::string cut = (scratch / "cut.pcapng").string();
  std::filesystem::copy_file(packets(), cut);
  std::filesystem::resize_file(cut, std::filesystem::file_size(cut) / 2);
  const ProgramRun run = program("'" + cut + "' --to 127.0.0.1:9 --network 127.7.30.0 --speed 5");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(run.err, HasSubstr("played up to there"));
}

}  // namespace
}  // namespace rigcal
