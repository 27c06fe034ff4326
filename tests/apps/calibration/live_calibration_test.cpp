#include "apps/calibration/live_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <thread>

#include "apps/calibration/calibration_run.h"
#include "apps/calibration/live_result.h"
#include "apps/capture/live_stops.h"
#include "tests/apps/calibration/growing_session.h"
#include "tests/support/files.h"
#include "tests/support/scratch_folder.h"
#include "tests/support/small_run.h"

namespace rigcal {
namespace {

namespace fs = std::filesystem;

class LiveCalibrationTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder = scratch_folder("live_calibration");
    simulate_courtyard(small_rig(), hurried_run(6, 0.9), folder / "given");
  }

  static inline fs::path folder;
  SilentReporter silent;
};

TEST_F(LiveCalibrationTest, EndsWithWhatCalibrateGivesForTheSession) {
  const fs::path session = folder / "session";
  begin_growing(folder / "given", session);
  auto recorder = PacketRecorder::create(session.string(), 0);
  ASSERT_TRUE(recorder.has_value());
  const StreamSource source = growing_session(session);
  LiveCalibration calibration(source.rig, {});
  LiveStops stops(source, recorder->progress(), calibration.sink());
  record_growing(folder / "given", *recorder, [](const Datagram&) { return true; });
  const auto reading = stops.finish({silent});
  ASSERT_TRUE(reading) << reading.error().message();
  // Slowly enough that something is known before the end.
  for (int i = 0; i < 600 && calibration.estimates().estimates.empty(); ++i) {
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  const LiveEstimates known = calibration.estimates();
  ASSERT_FALSE(known.estimates.empty());
  EXPECT_EQ(known.trouble, "");
  EXPECT_EQ(known.estimates.back().lidars.size(), 2U);
  const auto live = finish_live(session.string(), *reading, {}, calibration, (folder / "live").string(), {silent});
  ASSERT_TRUE(live) << live.error().message();
  EXPECT_GT(live->solved_s, 0.0);
  EXPECT_GT(live->wall_s, live->solved_s);
  EXPECT_FALSE(live->result.inputs.empty());

  CellOptions cells;
  cells.keep_thinned = true;
  const auto recording = read_recording({session.string(), {}, {}}, cells, {silent});
  ASSERT_TRUE(recording) << recording.error().message();
  auto result = calibrate_by_default(*recording, {silent});
  ASSERT_TRUE(result);
  ASSERT_TRUE(write_calibration(*recording, {}, (folder / "offline").string(), *result));
  for (const char* file : {"extrinsics.yaml", "trajectory.tum", "map.ply"}) {
    EXPECT_TRUE(text_of(folder / "live" / file) == text_of(folder / "offline" / file)) << file;
  }
}

TEST_F(LiveCalibrationTest, SaysWhichStopsTheSessionHasNoLonger) {
  const fs::path session = folder / "kept";
  begin_growing(folder / "given", session);
  auto recorder = PacketRecorder::create(session.string(), PacketRecorder::kLeastKept);
  ASSERT_TRUE(recorder.has_value());
  const StreamSource source = growing_session(session);
  LiveCalibration calibration(source.rig, {});
  LiveStops stops(source, recorder->progress(), calibration.sink());
  record_growing(folder / "given", *recorder, [&stops](const Datagram& datagram) {
    EXPECT_TRUE(is_followed(stops, datagram));
    return true;
  });
  const auto reading = stops.finish({silent});
  ASSERT_TRUE(reading) << reading.error().message();
  ASSERT_EQ(reading->stops.size(), 6U);
  NoPoints nowhere;
  const auto again = read_stops(source, {}, nowhere, {silent});
  ASSERT_TRUE(again) << again.error().message();
  ASSERT_LT(again->stops.size(), 6U);
  ASSERT_TRUE(recorder->forgotten_until_ns());
  const auto warning = lost_stops_warning(reading->stops, *recorder->forgotten_until_ns());
  ASSERT_TRUE(warning);
  const auto live = finish_live(session.string(), *reading, recorder->forgotten_until_ns(), calibration,
                                (folder / "kept_result").string(), {silent});
  ASSERT_TRUE(live) << live.error().message();
  EXPECT_THAT(live->result.warnings, testing::Contains(*warning));
  EXPECT_THAT(text_of(folder / "kept_result/report.json"), testing::HasSubstr(*warning));
}

TEST(LostStops, AreNamed) {
  std::vector<StopRecord> stops(3);
  for (int i = 0; i < 3; ++i) stops[static_cast<std::size_t>(i)].stop = {i, 100 * i + 10, 100 * i + 90};
  const std::string end = " (--keep): calibrating the session gives another result than this one";
  EXPECT_FALSE(lost_stops_warning({}, 500));
  EXPECT_FALSE(lost_stops_warning(stops, 9));
  EXPECT_EQ(lost_stops_warning(stops, 10), "of stop 0 the session has only the end" + end);
  EXPECT_EQ(lost_stops_warning(stops, 95), "stop 0 is not in the session any more" + end);
  EXPECT_EQ(lost_stops_warning(stops, 250),
            "stops 0 to 1 are not in the session any more, and of stop 2 the session has only the end" + end);
  EXPECT_EQ(lost_stops_warning(stops, 300), "stops 0 to 2 are not in the session any more" + end);
}

TEST_F(LiveCalibrationTest, ForgetsWhatItIsToldToForget) {
  const fs::path session = folder / "anew";
  begin_growing(folder / "given", session);
  const StreamSource source = growing_session(folder / "given");
  LiveCalibration calibration(source.rig, {}, {}, true);
  ASSERT_TRUE(read_stops(source, {}, calibration.sink(), {silent}));
  const LiveEstimates known = calibration.estimates();
  EXPECT_EQ(known.waiting, known.estimates.empty() ? 6 : 6 - known.estimates.back().stops);
  for (int i = 0; i < 600 && !calibration.view(); ++i) std::this_thread::sleep_for(std::chrono::milliseconds(50));
  ASSERT_TRUE(calibration.view());
  ASSERT_TRUE(calibration.sink().restart());
  EXPECT_FALSE(calibration.view());
  EXPECT_TRUE(calibration.estimates().estimates.empty());
  EXPECT_EQ(calibration.estimates().waiting, 0);
  ASSERT_TRUE(read_stops(source, {}, calibration.sink(), {silent}));
  const LidarRecording recording = calibration.finish().lidar;
  EXPECT_EQ(recording.stops.size(), 6U);
  for (const PatchCells& patch : recording.patches) EXPECT_LT(patch.stop, 6);
}

TEST_F(LiveCalibrationTest, StopsForWhichThereIsNoRoomAreLeftOutAndLeaveNoResult) {
  const StreamSource source = growing_session(folder / "given");
  LiveCalibration roomy(source.rig, {});
  ASSERT_TRUE(read_stops(source, {}, roomy.sink(), {silent}));
  EXPECT_EQ(roomy.estimates().left_out, 0);
  const LiveCells all = roomy.finish();
  EXPECT_EQ(all.left_out, 0);
  std::size_t bytes = 0;
  for (const PatchCells& patch : all.lidar.patches)
    bytes += (patch.cells.size() + patch.pieces.size()) * sizeof(Cell) + patch.thinned.size() * sizeof(Point);

  LiveCalibration tight(source.rig, {}, {}, false, bytes / 2);
  ASSERT_TRUE(read_stops(source, {}, tight.sink(), {silent}));
  ASSERT_TRUE(tight.sink().restart());  // What is found anew has the room again.
  EXPECT_EQ(tight.estimates().left_out, 0);
  const auto reading = read_stops(source, {}, tight.sink(), {silent});
  ASSERT_TRUE(reading);
  const int left_out = tight.estimates().left_out;
  EXPECT_GE(left_out, 2);
  EXPECT_LE(left_out, 4);
  const auto live = finish_live((folder / "given").string(), *reading, {}, tight, (folder / "none").string(), {silent});
  ASSERT_FALSE(live);
  EXPECT_THAT(live.error().message(), testing::HasSubstr("of its 6 stops " + std::to_string(left_out)));
  EXPECT_THAT(live.error().mend, testing::HasSubstr("rigcal calibrate"));
  EXPECT_FALSE(fs::exists(folder / "none"));
}

TEST_F(LiveCalibrationTest, IsGivenUpWithoutWaiting) {
  const StreamSource source = growing_session(folder / "given");
  LiveCalibration calibration(source.rig, {});
  EXPECT_FALSE(calibration.has_reached_goal());
  EXPECT_TRUE(calibration.finish().lidar.stops.empty());
}

}  // namespace
}  // namespace rigcal
