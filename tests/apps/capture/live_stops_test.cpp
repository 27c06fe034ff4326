#include "apps/capture/live_stops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <thread>

#include "apps/capture/packet_recorder.h"
#include "core/io/session_folder.h"
#include "drivers/livox_codec/discovery.h"
#include "drivers/livox_codec/sample_packet.h"
#include "tests/apps/calibration/growing_session.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using Kind = LiveStopEvent::Kind;

/// Everything that a sink is told, in its order.
class ToldSink final : public StopSink {
 public:
  Expected<void> restart() override {
    ++restarts;
    stops.clear();
    points_by_sensor.clear();
    sum = 0.0;
    return {};
  }
  [[nodiscard]] Expected<void> status() const override { return {}; }
  void points(int sensor, int stop, std::span<const Point> points) override {
    points_by_sensor[{stop, sensor}] += points.size();
    for (const Point& p : points) sum = 0.75 * sum + p.x + 2.0 * p.y + 3.0 * p.z;  // Order matters.
  }
  void stop_done(const StopRecord& stop) override { stops.push_back(stop); }

  int restarts = 0;
  std::vector<StopRecord> stops;
  std::map<std::pair<int, int>, std::uint64_t> points_by_sensor;
  double sum = 0.0;
};

class LiveStopsTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = scratch_folder("live_stops");
    simulate_courtyard(small_rig(), hurried_run(3, 1.2), folder / "given");
  }
  void SetUp() override {
    live = folder / testing::UnitTest::GetInstance()->current_test_info()->name();
    begin_growing(folder / "given", live);
  }

  StreamSource session() const { return growing_session(live); }
  template <class Keep>
  void record(PacketRecorder& recorder, Keep keep) const {
    record_growing(folder / "given", recorder, keep);
  }
  void expect_as_offline(const ToldSink& seen, const Expected<StopReading>& reading) {
    ASSERT_TRUE(reading.has_value()) << reading.error().message();
    ToldSink offline;
    const auto read = read_stops(session(), {}, offline, {silent});
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(reading->stops.size(), read->stops.size());
    EXPECT_EQ(reading->source, read->source);
    EXPECT_EQ(seen.points_by_sensor, offline.points_by_sensor);
    EXPECT_EQ(seen.sum, offline.sum);
    ASSERT_EQ(seen.stops.size(), offline.stops.size());
    for (std::size_t i = 0; i < seen.stops.size(); ++i) {
      EXPECT_EQ(seen.stops[i].stop.start_ns, offline.stops[i].stop.start_ns);
      EXPECT_EQ(seen.stops[i].stop.end_ns, offline.stops[i].stop.end_ns);
      EXPECT_EQ(seen.stops[i].R_previous_this, offline.stops[i].R_previous_this);
    }
  }
  std::vector<Kind> kinds(const std::vector<LiveStopEvent>& events) const {
    std::vector<Kind> out;
    for (const LiveStopEvent& event : events) out.push_back(event.kind);
    return out;
  }

  static inline fs::path folder;
  fs::path live;
  ToldSink sink;
  SilentReporter silent;
};

TEST_F(LiveStopsTest, FindsWhileItGrowsWhatIsFoundInTheEnd) {
  auto recorder = PacketRecorder::create(live.string(), 0);
  ASSERT_TRUE(recorder.has_value());
  LiveStops stops(session(), recorder->progress(), sink);
  record(*recorder, [](const Datagram&) { return true; });
  const auto reading = stops.finish({silent});
  expect_as_offline(sink, reading);
  ASSERT_EQ(sink.stops.size(), 3U);
  EXPECT_EQ(sink.restarts, 1);

  const std::vector<LiveStopEvent> events = stops.take_events();
  std::vector<Kind> seen = kinds(events);
  // A short rest of the swing may be told between two stops.
  EXPECT_EQ(std::count(seen.begin(), seen.end(), Kind::settled), 3);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), Kind::complete), 3);
  EXPECT_EQ(std::count(seen.begin(), seen.end(), Kind::anew), 0);
  std::int64_t settled_ns = 0;
  for (const LiveStopEvent& event : events) {
    if (event.kind == Kind::settled) settled_ns = event.stamp_ns;
    if (event.kind != Kind::complete) continue;
    ASSERT_TRUE(event.record.has_value());
    EXPECT_EQ(event.record->stop.start_ns, settled_ns);
    EXPECT_EQ(event.stamp_ns, event.record->stop.end_ns);
    EXPECT_EQ(event.record->points.size(), 2U);
  }
  EXPECT_TRUE(stops.take_events().empty());
  EXPECT_EQ(stops.status().stops, 3);
  EXPECT_FALSE(stops.status().failure.has_value());
}

TEST_F(LiveStopsTest, TellsOfAStopBeforeItsRecordingGoesOn) {
  auto recorder = PacketRecorder::create(live.string(), 0);
  LiveStops stops(session(), recorder->progress(), sink);
  const std::string path = session_packets_path((folder / "given").string());
  Datagram datagram;
  std::int64_t last_ns = 0;
  for (auto given = open_datagrams(path); *(*given)->next(datagram);) last_ns = datagram.stamp_ns;
  // All but the last stop.
  for (auto given = open_datagrams(path); *(*given)->next(datagram) && datagram.stamp_ns < last_ns - 1'500'000'000;) {
    ASSERT_TRUE(recorder->write(datagram).has_value());
  }
  ASSERT_TRUE(recorder->hand_over().has_value());
  for (int i = 0; i < 500 && stops.status().stops < 1; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  EXPECT_GE(stops.status().stops, 1);
  EXPECT_FALSE(stops.status().failure.has_value());
}  // And ends, although the recording has not.

TEST_F(LiveStopsTest, AUnitThatKeepsSilentIsNotWaitedFor) {
  auto recorder = PacketRecorder::create(live.string(), 0);
  LiveStops stops(session(), recorder->progress(), sink);
  record(*recorder, [](const Datagram& datagram) {
    const auto packet = livox::parse_sample_packet(datagram.bytes);
    return !packet || packet->header.data_type != livox::DataType::imu;
  });
  const auto reading = stops.finish({silent});
  expect_as_offline(sink, reading);
  EXPECT_EQ(reading->source, StopSource::points);
  EXPECT_GE(sink.restarts, 2);
}

TEST_F(LiveStopsTest, ADeviceThatNamesItselfLateIsReadAnew) {
  // Its address is not the rig's, so only the broadcast tells who it is.
  fs::remove(live / "rig.yaml");
  std::string yaml = small_rig();
  yaml.replace(yaml.find("192.168.1.21"), 12, "192.168.1.99");
  std::ofstream(live / "rig.yaml") << yaml;
  auto recorder = PacketRecorder::create(live.string(), 0);
  LiveStops stops(session(), recorder->progress(), sink);
  record(*recorder, [&recorder, i = 0](const Datagram& datagram) mutable {
    if (livox::parse_control_frame(datagram.bytes)) return false;
    if (++i != 3000) return true;
    const auto hello = livox::make_broadcast({"0TFDG3B00600551", livox::DeviceType::mid40, 0}, 1);
    const Endpoint host{{192, 168, 1, 5}, 55000};
    EXPECT_TRUE(recorder->write({datagram.stamp_ns, {{192, 168, 1, 21}, 65000}, host, hello}).has_value());
    return true;
  });
  const auto reading = stops.finish({silent});
  expect_as_offline(sink, reading);
  EXPECT_GE(sink.restarts, 2);
  EXPECT_TRUE(sink.points_by_sensor.contains({0, 1}));
}

TEST_F(LiveStopsTest, ReadsOnWhereOnlyTheNewestIsKept) {
  auto recorder = PacketRecorder::create(live.string(), PacketRecorder::kLeastKept);
  LiveStops stops(session(), recorder->progress(), sink);
  record(*recorder, [&stops](const Datagram& datagram) {
    EXPECT_TRUE(is_followed(stops, datagram));
    return true;
  });
  EXPECT_GT(recorder->progress()->parts(), 3);
  const auto reading = stops.finish({silent});
  ASSERT_TRUE(reading.has_value());
  EXPECT_EQ(reading->stops.size(), 3U);
}

TEST_F(LiveStopsTest, TheEndOfAnEmptyRecordingIsAnEnd) {
  auto recorder = PacketRecorder::create(live.string(), 0);
  LiveStops stops(session(), recorder->progress(), sink);
  ASSERT_TRUE(recorder->close().has_value());
  const auto reading = stops.finish({silent});
  ASSERT_TRUE(reading.has_value()) << reading.error().message();
  EXPECT_TRUE(reading->stops.empty());
}

}  // namespace
}  // namespace rigcal
