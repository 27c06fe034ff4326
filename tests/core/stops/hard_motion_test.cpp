// What troubles a stop, seen by the gyro with the points watching, and by the points where there is no gyro.
#include <gmock/gmock.h>

#include <array>

#include "core/stops/stop_finder.h"
#include "tests/core/stops/point_run.h"

namespace rigcal {
namespace {

class StopsOnly final : public PatchSink {
 public:
  void points(int, int, std::span<const Point>) override {}
  void stop_done(const StopRecord& stop) override { stops.push_back(stop); }
  std::vector<StopRecord> stops;
};

struct Found {
  bool by_gyro;
  std::vector<StopRecord> stops;
};

// What a gyro and what the points alone tell of the same run: to simulate it costs more than both.
std::array<Found, 2> find(const PointRun& run) {
  StopsOnly of_gyro;
  StopsOnly of_points;
  StopFinder by_gyro({.source = StopSource::gyro, .turn_axes = run.turn_axes()}, of_gyro);
  StopFinder by_points({.source = StopSource::points, .turn_axes = run.turn_axes()}, of_points);
  const std::vector<ImuSample> imu = run.imu();
  std::size_t next = 0;
  run.play([&](const PointBatch& batch) {
    for (; next < imu.size() && imu[next].stamp_ns <= batch.stamp_ns; ++next) {
      by_gyro.add_imu(imu[next]);
      by_points.add_imu(imu[next]);
    }
    by_gyro.add_points(batch);
    by_points.add_points(batch);
  });
  by_gyro.flush();
  by_points.flush();
  return {{{true, of_gyro.stops}, {false, of_points.stops}}};
}

PointRun::Options courtyard(int stops) {
  PointRun::Options options;
  options.scene = "courtyard";
  options.turntable.stops = stops;
  options.shots_per_s = 40'000.0;
  return options;
}

Deviation deviation(const PointRun& run, const StopRecord& stop) {
  return deviation_in(run.motion(), to_seconds(stop.stop.start_ns), to_seconds(stop.stop.end_ns));
}

double length_s(const StopRecord& stop) { return 1e-9 * static_cast<double>(stop.stop.end_ns - stop.stop.start_ns); }

TEST(HardMotion, OvershootIsNoStopAndNotInOne) {
  PointRun::Options options = courtyard(4);
  options.turntable.overshoot_rad = to_rad(1.0);
  const PointRun run(options);
  for (const auto& [by_gyro, stops] : find(run)) {
    SCOPED_TRACE(by_gyro ? "by the gyro" : "by the points");
    ASSERT_EQ(stops.size(), 4U);
    for (const StopRecord& stop : stops) {
      EXPECT_LE(deviation(run, stop).rotation_deg, by_gyro ? 0.01 : 0.03);
      EXPECT_LE(deviation(run, stop).translation_mm, 0.2);
    }
  }
}

TEST(HardMotion, DwellsOfAnyLengthAreFound) {
  PointRun::Options options = courtyard(6);
  options.turntable.dwell_range_s = {1.2, 6.0};
  const PointRun run(options);
  for (const auto& [by_gyro, stops] : find(run)) {
    SCOPED_TRACE(by_gyro ? "by the gyro" : "by the points");
    ASSERT_EQ(stops.size(), 6U);
    for (const StopRecord& stop : stops) EXPECT_LE(deviation(run, stop).rotation_deg, by_gyro ? 0.01 : 0.05);
  }
}

// A gyro takes this for a change of its bias; the points end the stop.
TEST(HardMotion, CreepEndsAStop) {
  PointRun::Options options = courtyard(2);
  options.turntable.creep_rad_per_s = to_rad(0.02);
  options.turntable.dwell_s = 15.0;
  const PointRun run(options);
  for (const auto& [by_gyro, stops] : find(run)) {
    SCOPED_TRACE(by_gyro ? "by the gyro" : "by the points");
    if (by_gyro) {
      ASSERT_EQ(stops.size(), 2U);
      EXPECT_EQ(stops[0].end, StopEnd::creep);
    } else {
      ASSERT_GE(stops.size(), 6U);
    }
    for (const StopRecord& stop : stops) {
      EXPECT_LE(length_s(stop), 5.0);
      EXPECT_LE(deviation(run, stop).rotation_deg, 0.05) << "stop " << stop.stop.index;
    }
  }
}

TEST(HardMotion, ABumpedStopKeepsOnePlaceInAPatch) {
  PointRun::Options options = courtyard(3);
  options.turntable.dwell_s = 4.0;
  options.turntable.bumps = {{1, 2.0, to_rad(0.2)}};
  const PointRun run(options);
  for (const auto& [by_gyro, stops] : find(run)) {
    SCOPED_TRACE(by_gyro ? "by the gyro" : "by the points");
    ASSERT_EQ(stops.size(), 4U);
    for (const StopRecord& stop : stops) EXPECT_LE(deviation(run, stop).rotation_deg, 0.03) << stop.stop.index;
    ASSERT_TRUE(stops[2].rotation_known);
    EXPECT_NEAR(to_deg(log_so3(stops[2].R_previous_this).norm()), 0.2, 0.05);
  }
}

TEST(HardMotion, AStopCutByTheEndsOfTheRecordingIsUsed) {
  PointRun::Options options = courtyard(2);
  options.lead_s = 1.5;
  options.tail_s = 1.0;
  const PointRun run(options);
  for (const auto& [by_gyro, stops] : find(run)) {
    SCOPED_TRACE(by_gyro ? "by the gyro" : "by the points");
    ASSERT_EQ(stops.size(), 2U);
    EXPECT_GE(length_s(stops[0]), 1.2);
    EXPECT_GE(length_s(stops[1]), 0.6);
  }
}

// A calm run must lose nothing to the points that watch over the gyro.
TEST(CreepGuard, PointsLeaveTheStopsOfAGyroAlone) {
  for (const char* scene : {"courtyard", "room", "sparse"}) {
    SCOPED_TRACE(scene);
    PointRun::Options options = courtyard(5);
    options.scene = scene;
    options.lidars = {0, 1, 2};
    const PointRun run(options);
    const std::vector<StopRecord> stops = find(run)[0].stops;
    ASSERT_EQ(stops.size(), 5U);
    for (const StopRecord& stop : stops) {
      EXPECT_NE(stop.end, StopEnd::creep);
      EXPECT_GE(length_s(stop), 1.1);
      EXPECT_LE(deviation(run, stop).rotation_deg, 0.01);
    }
  }
}

}  // namespace
}  // namespace rigcal
