#include "apps/capture/capture_guide.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "apps/capture/packet_recorder.h"
#include "apps/recording/datagram_file.h"
#include "core/io/session_folder.h"
#include "simdata/live/virtual_table.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;
using testing::Contains;

/// A simulated run that is recorded bit by bit, and a guide that looks at it.
class CaptureGuideTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = scratch_folder("guide");
    simulate_courtyard(small_rig(), hurried_run(3, 1.5), folder / "given");
  }
  void SetUp() override {
    live = folder / testing::UnitTest::GetInstance()->current_test_info()->name();
    fs::create_directories(live);
    fs::copy_file(folder / "given" / "rig.yaml", live / "rig.yaml");
    StreamSource source;
    source.path = live.string();
    source.file = session_packets_path(live.string());
    source.rig = *load_rig((live / "rig.yaml").string());
    recorder.emplace(*PacketRecorder::create(live.string(), 0));
    stops.emplace(std::move(source), recorder->progress(), no_points);
    devices.resize(2);
    for (livox::DeviceReport& device : devices) {
      device.link.state = livox::LinkState::sampling;
      device.packets = 1;
    }
    goal.stops = 3;
    goal.dwell_s = 0.6;
  }
  /// Until the guide wants to end or the run is over; `each` is called ten times a second of the run.
  template <class Each>
  bool record(CaptureGuide& guide, const Each& each) {
    const auto given = open_datagrams(session_packets_path((folder / "given").string()));
    Datagram datagram;
    std::int64_t looked_ns = 0;
    while (*(*given)->next(datagram)) {
      EXPECT_TRUE(recorder->write(datagram).has_value());
      if (datagram.stamp_ns < looked_ns + 100'000'000) continue;
      looked_ns = datagram.stamp_ns;
      EXPECT_TRUE(recorder->hand_over().has_value());
      for (int i = 0; i < 200 && stops->status().read_until_ns < looked_ns - 60'000'000; ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(2));
      each();
      const CaptureGuide::Wish wish = guide.look(looked_ns, devices, cameras);
      secured += wish.secure ? 1 : 0;
      for (const CaptureEvent& event : guide.take_events()) {
        said.push_back(event.text);
        if (event.text.find(" is over, ") != std::string::npos) over_ns.push_back(event.stamp_ns);
      }
      if (wish.end) return true;
    }
    return false;
  }

  static inline fs::path folder;
  fs::path live;
  NoPoints no_points;
  std::optional<PacketRecorder> recorder;
  std::optional<LiveStops> stops;
  CaptureGoal goal;
  std::vector<livox::DeviceReport> devices;
  std::vector<CaptureCamera> cameras;
  std::vector<std::string> said;
  std::vector<std::int64_t> over_ns;  ///< By the events that tell of stops that are over.
  int secured = 0;
};

TEST_F(CaptureGuideTest, EndsWhenTheStopsAreIn) {
  CaptureGuide guide(goal, {"avia", "mid40"}, {}, *stops, nullptr);
  EXPECT_TRUE(record(guide, [] {}));
  EXPECT_EQ(guide.progress().state, CaptureState::ended);
  EXPECT_EQ(guide.progress().stops, 3);
  EXPECT_EQ(secured, 3);
  EXPECT_EQ(guide.stops().size(), 2U);  // The last one goes on.
  // By the numbers that the session's files have.
  EXPECT_THAT(said, Contains("stop 0 counts: 1 of 3 stops in"));
  EXPECT_THAT(said, Contains(testing::StartsWith("stop 0 is over, ")));
  ASSERT_EQ(over_ns.size(), 2U);
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(over_ns[i], guide.stops()[i].end_ns);
  EXPECT_THAT(said, Contains("stop 2 counts: 3 of 3 stops in"));
  EXPECT_THAT(said, Contains("moving"));
  EXPECT_THAT(said, Contains("ended"));
  // At rest: no motion ends the last one.
  ASSERT_TRUE(recorder->close());
  SilentReporter silent;
  ASSERT_TRUE(stops->finish({silent}));
  guide.look(stops->status().read_until_ns, devices, cameras);
  ASSERT_EQ(guide.stops().size(), 3U);
  const std::vector<CaptureEvent> last = guide.take_events();
  ASSERT_FALSE(last.empty());
  EXPECT_THAT(last[0].text, testing::StartsWith("stop 2 is over, "));
  EXPECT_THAT(last[0].text, testing::EndsWith("ended by the end of the recording"));
}

TEST_F(CaptureGuideTest, WantsImagesInStopsThatAreNotFull) {
  goal.dwell_s = 0.9;  // Some looks long: shorter ones may be full as soon as they are known.
  CaptureGuide guide(goal, {"avia", "mid40"}, {}, *stops, nullptr);
  EXPECT_FALSE(guide.wants_images());
  int wanted = 0;
  int unwanted = 0;
  EXPECT_TRUE(record(guide, [&] {
    const CaptureProgress progress = guide.progress();
    const bool is_time = progress.state == CaptureState::capturing && !progress.is_full;
    EXPECT_EQ(guide.wants_images(), is_time);
    ++(is_time ? wanted : unwanted);
  }));
  EXPECT_GT(wanted, 0);
  EXPECT_GT(unwanted, 5);
  EXPECT_FALSE(guide.wants_images());
  // Packets of long ago do not tell what the rig does now.
  CaptureGuide blind(goal, {"avia", "mid40"}, {}, *stops, nullptr);
  blind.look(stops->status().read_until_ns + 10'000'000'000, devices, cameras);
  EXPECT_TRUE(blind.wants_images());
}

TEST_F(CaptureGuideTest, ASensorThatGoesAndComesIsNoted) {
  CaptureGuide guide(goal, {"avia", "mid40"}, {}, *stops, nullptr);
  int looks = 0;
  bool was_absent = false;
  EXPECT_TRUE(record(guide, [&] {
    devices[1].link.state = ++looks >= 10 && looks < 20 ? livox::LinkState::waiting : livox::LinkState::sampling;
    was_absent = was_absent || guide.progress().absent == std::vector<std::string>{"mid40"};
  }));
  EXPECT_TRUE(was_absent);
  EXPECT_EQ(guide.progress().stops, 3);
}

TEST_F(CaptureGuideTest, ALidarThatAnswersButWhosePacketsDoNotComeIsNotThere) {
  CaptureGuide guide(goal, {"avia", "mid40"}, {}, *stops, nullptr);
  devices[1].packets = 0;
  guide.look(1'000'000'000, devices, cameras);
  EXPECT_EQ(guide.progress().state, CaptureState::checking);
  EXPECT_EQ(guide.progress().absent, std::vector<std::string>{"mid40"});
  devices[1].packets = 1;
  guide.look(1'100'000'000, devices, cameras);
  EXPECT_TRUE(guide.progress().absent.empty());
}

TEST_F(CaptureGuideTest, AnImageOfAnotherStopDoesNotFillThisOne) {
  cameras.resize(1);
  cameras[0].sensor = "camera";
  cameras[0].state = "sends";
  goal.frame_s = 100.0;
  CaptureGuide guide(goal, {"avia", "mid40"}, {"camera"}, *stops, nullptr);
  bool had_image = false;
  EXPECT_TRUE(record(guide, [&] {
    const LiveStopStatus status = stops->status();
    // One in the middle of each stop, but the second.
    if (status.rest && status.rest->stop >= 0 && status.rest->stop != 1)
      cameras[0].last_image_ns = status.rest->settled_ns + 200'000'000;
    had_image = had_image || cameras[0].last_image_ns > 0;
  }));
  // The second stop lasted, and counts by that.
  EXPECT_EQ(guide.progress().stops, 3);
  EXPECT_TRUE(had_image);
}

TEST_F(CaptureGuideTest, ATableThatDoesNotTurnEndsIt) {
  auto other_end = sim::VirtualTable::start({});
  if (!other_end) GTEST_SKIP() << other_end.error().message();
  turntable::TableOptions wanted;
  wanted.port = (*other_end)->port();
  auto started = turntable::Table::start(wanted, net::read_clocks());
  ASSERT_TRUE(started) << started.error().message();
  auto table = TableRecorder::create(*std::move(started), live.string());
  ASSERT_TRUE(table) << table.error().message();
  goal.turns_itself = true;
  goal.table_s = 0.8;  // Of the run's time.
  (*other_end)->jam(true);
  CaptureGuide guide(goal, {"avia", "mid40"}, {}, *stops, table->get());
  EXPECT_TRUE(record(guide, [] {}));
  EXPECT_EQ(guide.progress().state, CaptureState::failed);
  EXPECT_EQ(guide.progress().stops, 1);
  EXPECT_THAT(said, Contains("the table is told to turn"));
  EXPECT_THAT(said, Contains(testing::HasSubstr("failed: the table has not arrived")));
  EXPECT_TRUE(fs::exists(live / "turntable.csv"));
}

}  // namespace
}  // namespace rigcal
