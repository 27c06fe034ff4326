// Virtual devices on loopback, the driver, the recorder and the way to points, as one.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <map>
#include <thread>

#include "apps/capture/capture.h"
#include "apps/capture/live_datagrams.h"
#include "apps/recording/batch_source.h"
#include "drivers/livox_codec/sample_packet.h"
#include "drivers/net/udp_socket.h"
#include "simdata/live/live_run.h"
#include "simdata/scene/scene_file.h"
#include "tests/support/files.h"
#include "tests/support/json.h"
#include "tests/support/noting_reporter.h"
#include "tests/support/run_program.h"
#include "tests/support/schema_check.h"
#include "tests/support/scratch_folder.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

constexpr std::uint16_t discovery_port = 55018;  // Not the usual one: other tests run at the same time.

Rig loopback_rig() {
  auto rig = load_rig(std::string(RIGCAL_SOURCE_DIR) + "/config/rigs/loopback.yaml");
  EXPECT_TRUE(rig.has_value());
  return *std::move(rig);
}

sim::LiveOptions short_run() {
  sim::LiveOptions live;
  live.run.seed = 3;
  live.run.turntable.stops = 2;
  live.run.turntable.dwell_s = 0.4;
  live.run.turntable.initial_still_s = 1.2;
  live.run.turntable.turn_s = 0.4;
  live.run.turntable.final_still_s = 0.2;
  live.discovery_port = discovery_port;
  live.device.broadcast_s = 0.1;
  live.device.spin_up_s = 0.1;
  return live;
}

using Records = std::vector<std::uint8_t>;

Records records_of(const Datagram& datagram) { return {datagram.bytes.begin() + 18, datagram.bytes.end()}; }

/// The points of all packets by device, as `simulate --out` makes them.
std::map<int, std::vector<Records>> offline_points(const Rig& rig, const sim::RunOptions& options) {
  const auto scene = sim::load_scene("room");
  SilentReporter silent;
  std::map<int, std::vector<Records>> points;
  const auto sink = [&](const Datagram& datagram) -> Expected<void> {
    if (datagram.from.port == livox::kPointSourcePort) points[datagram.from.ip[3]].push_back(records_of(datagram));
    return {};
  };
  EXPECT_TRUE(sim::simulate_run(*scene, rig, options, sink, {silent}).has_value());
  return points;
}

struct Seen {
  std::uint64_t batches = 0;
  std::uint64_t readings = 0;
  std::vector<std::int64_t> stamps;
  std::vector<float> coordinates;
  bool operator==(const Seen&) const = default;
};

BatchSinks sinks_of(Seen& seen) {
  BatchSinks sinks;
  sinks.points = [&seen](PointBatch& batch) {
    ++seen.batches;
    seen.stamps.push_back(batch.stamp_ns);
    for (const Point& point : batch.points) seen.coordinates.push_back(point.x);
  };
  sinks.imu = [&seen](const ImuSample& sample) {
    ++seen.readings;
    seen.stamps.push_back(sample.stamp_ns);
  };
  return sinks;
}

class Live : public testing::Test {
 protected:
  void SetUp() override {
    scratch = scratch_folder("live");
    options.discovery_port = discovery_port;
    options.queue_datagrams = 1U << 13U;
  }

  std::filesystem::path scratch;
  const Rig rig = loopback_rig();
  livox::DriverOptions options = *driver_options(rig);
};

TEST_F(Live, ARecordedRunIsTheSimulatedOneAndReadsAsItWasSeen) {
  auto driver = livox::Driver::start(options);
  ASSERT_TRUE(driver.has_value()) << driver.error().message();
  sim::LiveOptions live = short_run();
  std::stop_source stop;
  std::optional<sim::LiveSummary> summary;
  std::thread devices([&] {
    const auto scene = sim::load_scene("room");
    SilentReporter silent;
    auto served = sim::serve_live(*scene, rig, live, {silent});
    EXPECT_TRUE(served.has_value()) << (served ? "" : served.error().message());
    if (served) summary = *served;
    stop.request_stop();
  });
  const std::string path = (scratch / "lidar.pcapng").string();
  auto recorder = PcapngWriter::create(path);
  ASSERT_TRUE(recorder.has_value());
  Seen seen;
  const auto source =
      make_batches(std::make_unique<LiveDatagrams>(**driver, &*recorder, stop.get_token()), rig, sinks_of(seen));
  while (true) {
    const auto more = source->read_some();
    ASSERT_TRUE(more.has_value());
    if (!*more) break;
  }
  devices.join();
  ASSERT_TRUE(recorder->close().has_value());
  ASSERT_TRUE(summary.has_value());
  EXPECT_TRUE(summary->is_complete);

  // Nothing is lost that is not counted.
  const auto interfaces = (*driver)->interfaces();
  const livox::ReceiverCounters& counters = interfaces[0].counters;
  EXPECT_EQ(counters.received + counters.dropped_by_kernel + counters.dropped_by_queue + counters.strangers,
            summary->packets - summary->unsent);
  EXPECT_EQ(counters.dropped_by_queue, 0U);
  EXPECT_EQ(seen.batches + seen.readings, counters.received);
  EXPECT_GT(seen.readings, 200U);

  // What was seen live comes out of the recording again, to the bit.
  Seen again;
  auto recorded = open_batches(path, rig, sinks_of(again));
  ASSERT_TRUE(recorded.has_value());
  while (*(*recorded)->read_some()) {
  }
  EXPECT_TRUE(seen == again);

  // And every packet is one of the simulated run, in its order.
  auto offline = offline_points(rig, live.run);
  std::map<int, std::size_t> next;
  std::map<int, std::size_t> matched;
  auto file = open_datagrams(path);
  ASSERT_TRUE(file.has_value());
  Datagram datagram;
  while (*(*file)->next(datagram)) {
    if (datagram.from.port != livox::kPointSourcePort) continue;
    const int device = datagram.from.ip[3];
    const auto& run = offline[device];
    std::size_t& at = next[device];
    const Records records = records_of(datagram);
    while (at < run.size() && run[at] != records) ++at;
    ASSERT_LT(at, run.size()) << "a packet that the simulation does not have, or out of order";
    ++at;
    ++matched[device];
  }
  // The first device starts the run; the others miss the time until their own start.
  for (const auto& [device, run] : offline) EXPECT_GT(matched[device], run.size() / 4) << device;
}

TEST_F(Live, TroubledDevicesAreTakenAgainAndTheRestIsNotDisturbed) {
  auto driver = livox::Driver::start(options);
  ASSERT_TRUE(driver.has_value());
  sim::LiveOptions live = short_run();
  live.loop = true;
  live.control.drop = 0.1;
  live.control.duplicate = 0.1;
  live.run.faults.loss = 0.05;
  live.device.boot_s = 0.2;
  live.incidents = {*sim::parse_incident("mid100_left,1.5,reboot"), *sim::parse_incident("avia,2.5,status,0x40000001"),
                    *sim::parse_incident("mid100_right,0.5,refuse,read_extrinsics"),
                    *sim::parse_incident("mid100_middle,1.5,clock,-3.5")};
  std::stop_source stop;
  std::thread devices([&] {
    const auto scene = sim::load_scene("room");
    SilentReporter silent;
    const auto served = sim::serve_live(*scene, rig, live, {silent, stop.get_token()});
    EXPECT_TRUE(served.has_value());
    EXPECT_TRUE(!served || !served->is_complete);
  });
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  Datagram datagram;
  std::size_t sampling = 0;
  bool was_lost = false;
  bool was_warned = false;
  while (std::chrono::steady_clock::now() < end && !(was_lost && was_warned && sampling == 4)) {
    while ((*driver)->next(datagram, 1'000'000)) {
    }
    sampling = 0;
    for (const livox::DeviceReport& report : (*driver)->devices()) {
      if (report.link.state == livox::LinkState::sampling) ++sampling;
      if (report.link.broadcast.broadcast_code == "0TFDG3B00600551" && report.link.counters.losses > 0) was_lost = true;
      if (report.link.status == 0x40000001) was_warned = true;
    }
  }
  EXPECT_TRUE(was_lost);
  EXPECT_TRUE(was_warned);
  EXPECT_EQ(sampling, 4U);
  stop.request_stop();
  devices.join();
}

TEST_F(Live, ARigWithoutAddressesOrLidarsCannotBeTaken) {
  Rig bare = rig;
  bare.sensors[0].lidar->ip.reset();
  bare.sensors[0].lidar->broadcast_code.clear();
  const auto refused = driver_options(bare);
  ASSERT_FALSE(refused.has_value());
  EXPECT_THAT(refused.error().message(), HasSubstr("neither a broadcast_code nor an ip"));
  bare.sensors.clear();
  EXPECT_FALSE(driver_options(bare).has_value());
  ASSERT_EQ(options.devices.size(), 4U);
  EXPECT_EQ(options.interface, "lo");
  EXPECT_EQ(options.devices[0].settings.imu_rate, livox::ImuRate::hz_200);
  EXPECT_FALSE(options.devices[1].settings.imu_rate.has_value());
}

ProgramRun simulate(const std::string& arguments, const std::filesystem::path& scratch) {
  return run_program(std::string("timeout -s INT 4 '") + RIGCAL_PROGRAM + "' simulate room --rig '" +
                         RIGCAL_SOURCE_DIR + "/config/rigs/loopback.yaml' " + arguments,
                     scratch);
}

// As `| tee log` does at Ctrl-C, which ends tee first. Without cameras, whose libraries ignore that signal, too.
TEST_F(Live, ACaptureGoesOnThoughNobodyReadsWhatItSaysAnyMore) {
  const std::filesystem::path session = scratch / "session";
  const std::filesystem::path file = scratch / "lidar.yaml";
  std::ofstream(file) << "rigcal: 1\nname: lidar\nbase: avia\nsensors:\n"
                         "  avia: {type: livox_avia, broadcast_code: \"3JEDHC900100791\", ip: 127.0.0.179}\n"
                         "lidar: {interface: lo}\n";
  run_program(std::string("env --default-signal=PIPE '") + RIGCAL_PROGRAM + "' capture --rig '" + file.string() +
                  "' --duration 1 --out '" + session.string() + "' 2>&1 | true",
              scratch);
  const auto record = try_json(text_of(session / "session.json"));
  ASSERT_FALSE(record.is_discarded());
  EXPECT_TRUE(record["end_ns"].is_number()) << "it was killed on the way";
}

// Whom the points go to has no room for them.
class FullSink final : public StopSink {
 public:
  Expected<void> restart() override { return system_error("no room for points"); }
  [[nodiscard]] Expected<void> status() const override { return {}; }
  void points(int, int, std::span<const Point>) override {}
  void stop_done(const StopRecord&) override {}
};

TEST_F(Live, ACaptureSaysAtOnceAndInTheEndThatStopsAreNotFoundAnyMore) {
  Rig lidars = rig;
  std::erase_if(lidars.sensors, [](const Sensor& sensor) { return !sensor.is_lidar(); });
  FullSink sink;
  NotingReporter reporter;
  CaptureOptions wanted;
  wanted.out = (scratch / "session").string();
  wanted.sink = &sink;
  wanted.goal.stops = 1;
  wanted.is_enough = [&reporter] { return !reporter.warnings.empty(); };
  wanted.duration_s = 10.0;
  const auto summary = capture(lidars, options, wanted, {reporter}, [](const CaptureStatus&) {});
  ASSERT_TRUE(summary) << summary.error().message();
  EXPECT_LT(summary->status.seconds, 5.0) << "it was told only at the end";
  EXPECT_THAT(reporter.warnings,
              testing::Contains(HasSubstr("no more stops are found, the recording goes on: no room")));
  std::vector<std::string> told;
  for (const Shortfall& shortfall : summary->shortfalls()) told.push_back(shortfall.message());
  EXPECT_THAT(told, testing::Contains(HasSubstr("stops could not be found while it was recorded: no room for points")));
  EXPECT_THAT(text_of(scratch / "session/session.json"), HasSubstr("stops: no room for points"));
}

TEST_F(Live, TheProgramServesUntilItIsStopped) {
  // In the foreground, as the signal would come twice otherwise, and the second one ends the program at once.
  const ProgramRun run = run_program(std::string("timeout --foreground --preserve-status -s INT 2 '") + RIGCAL_PROGRAM +
                                         "' simulate room --rig '" + RIGCAL_SOURCE_DIR +
                                         "/config/rigs/loopback.yaml' --live --loop --stops 1 --dwell 0.2 --json",
                                     scratch);
  ASSERT_EQ(run.code, 0) << run.err;
  const auto summary = parse_json(run.out);
  EXPECT_TRUE(fits_schema("simulate_live.json", summary));
  EXPECT_EQ(summary["complete"], false);
  EXPECT_EQ(summary["packets"], 0);  // Nobody asked for any.
  ASSERT_EQ(summary["cameras"].size(), 2U);
  EXPECT_EQ(summary["cameras"][0]["name"], "camera_left");
  EXPECT_EQ(summary["cameras"][0]["address"], "127.0.0.31");
  EXPECT_EQ(summary["cameras"][1]["address"], "127.0.0.32");
  EXPECT_EQ(summary["cameras"][1]["frames"], 0);
}

TEST_F(Live, ACaptureThatHearsNobodyNamesWhoElseWaitsForTheLidars) {
  net::UdpOptions waiting;
  waiting.local = {{0, 0, 0, 0}, livox::kDiscoveryPort};
  waiting.reuse_address = true;
  const auto rival = net::UdpSocket::open(waiting);
  ASSERT_TRUE(rival.has_value()) << rival.error().message();
  const ProgramRun run =
      run_program(std::string("'") + RIGCAL_PROGRAM + "' capture --rig '" + RIGCAL_SOURCE_DIR +
                      "/config/rigs/loopback.yaml' --duration 7 --quiet --out '" + (scratch / "session").string() + "'",
                  scratch);
  EXPECT_EQ(run.code, 4) << run.err;
  EXPECT_THAT(run.err,
              HasSubstr("no broadcast of avia, mid100_left, mid100_middle, mid100_right was heard yet, and UDP "
                        "port 55000 is also taken by "));
  EXPECT_THAT(run.err, HasSubstr("(process " + std::to_string(getpid()) + ")"));
}

TEST_F(Live, TheProgramRefusesWhatDoesNotFit) {
  EXPECT_EQ(simulate("", scratch).code, 2);
  EXPECT_EQ(simulate("--live --patches", scratch).code, 2);
  EXPECT_EQ(simulate("--live --out s", scratch).code, 2);
  EXPECT_EQ(simulate("--speed 2 --out s", scratch).code, 2);
  for (const char* incident : {"avia", "avia,1,jump", "avia,x,reboot", "avia,1,silence", "avia,1,status,xyz",
                               "avia,1,reboot,2", "avia,1,clock", "avia,1,clock,x", "avia,1,refuse,everything"}) {
    const ProgramRun run = simulate(std::string("--live --incident ") + incident, scratch);
    EXPECT_EQ(run.code, 2) << incident;
    EXPECT_THAT(run.err, HasSubstr("SENSOR,SECONDS,reboot"));
  }
  const ProgramRun unknown = simulate("--live --incident nobody,1,reboot", scratch);
  EXPECT_EQ(unknown.code, 3);
  EXPECT_EQ(simulate("--live --incident camera_left,1,status,1", scratch).code, 3);
  EXPECT_THAT(unknown.err, HasSubstr("no device 'nobody'"));
}

}  // namespace
}  // namespace rigcal
