#include "core/stops/stop_finder.h"

#include <gmock/gmock.h>

#include <numeric>

#include "tests/core/stops/rig_motion.h"

namespace rigcal {
namespace {

RigMotion three_stops() {
  RigMotion motion;
  for (int i = 0; i < 3; ++i) {
    motion.turn(18.0, 20.0, 100.0);
    motion.rest(2.0);
  }
  motion.turn(18.0, 20.0, 100.0);
  return motion;
}

struct Event {
  double arrival_s;
  bool imu;
  ImuSample sample;
  PointBatch batch;
};

// Gyro and two sensors of 10 000 points/s; the second one arrives `lag_s` late.
std::vector<Event> record(const RigMotion& motion, double lag_s) {
  Random random(1);
  std::vector<Event> events;
  for (const ImuSample& sample : read_gyro(motion, GyroModel{}, random)) {
    events.push_back({to_seconds(sample.stamp_ns), true, sample, {}});
  }
  for (int sensor = 1; sensor <= 2; ++sensor) {
    for (double t = 0.0; t < motion.length_s(); t += 0.01) {
      events.push_back({t + 0.01 + (sensor == 2 ? lag_s : 0.0), false, {}, timed_batch(sensor, t, 100, 1e-4)});
    }
  }
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.arrival_s < b.arrival_s; });
  return events;
}

std::uint64_t dropped(const StopFinder& finder, DropReason reason) {
  return finder.point_counts().dropped[static_cast<std::size_t>(reason)];
}

void feed(StopFinder& finder, const std::vector<Event>& events) {
  for (const Event& event : events) {
    if (event.imu) {
      finder.add_imu(event.sample);
    } else {
      finder.add_points(event.batch);
    }
  }
  finder.flush();
}

class StopFinderLag : public testing::TestWithParam<double> {};

TEST_P(StopFinderLag, HandsOutAllPointsInsideStopsAndNoOthers) {
  const RigMotion motion = three_stops();
  const std::vector<Event> events = record(motion, GetParam());
  CollectingSink sink;
  StopFinder finder(StopOptions{}, sink);
  feed(finder, events);
  ASSERT_EQ(sink.stops.size(), 3U);
  EXPECT_FALSE(sink.has_points_without_stop());
  for (std::size_t i = 0; i < 3; ++i) {
    const FoundStop& stop = sink.stops[i];
    const double start_s = to_seconds(stop.record.stop.start_ns);
    const double end_s = to_seconds(stop.record.stop.end_ns);
    EXPECT_EQ(stop.record.stop.index, static_cast<int>(i));
    EXPECT_GE(end_s - start_s, 0.8 * 2.0);
    for (int sensor = 1; sensor <= 2; ++sensor) {
      const std::vector<double>& times = stop.times_s.at(sensor);
      EXPECT_EQ(times.size(), stop.record.points.at(sensor));
      // A point every 0.1 ms, none left out at the ends or between; 1 us for the float that carries the time.
      EXPECT_NEAR(static_cast<double>(times.size()), (end_s - start_s) * 1e4, 1.0);
      EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
      EXPECT_GE(times.front(), start_s - 1e-6);
      EXPECT_LE(times.back(), end_s + 1e-6);
      EXPECT_GE(times.front(), motion.rests()[i].start_s);
      EXPECT_LE(times.back(), motion.rests()[i].end_s);
    }
  }
}
INSTANTIATE_TEST_SUITE_P(StopFinder, StopFinderLag, testing::Values(0.0, 0.05, 0.3, -0.05));

TEST(StopFinder, CountsEveryPointOnce) {
  const std::vector<Event> events = record(three_stops(), 0.02);
  CollectingSink sink;
  StopFinder finder(StopOptions{}, sink);
  feed(finder, events);
  std::uint64_t fed = 0;
  for (const Event& event : events) fed += event.batch.points.size();
  const PointCounts& counts = finder.point_counts();
  EXPECT_EQ(std::accumulate(counts.dropped.begin(), counts.dropped.end(), counts.in_stops), fed);
  EXPECT_GT(dropped(finder, DropReason::before_first_stop), 0U);
  EXPECT_GT(dropped(finder, DropReason::moving), 0U);
  EXPECT_GT(dropped(finder, DropReason::swing), 0U);
  EXPECT_EQ(dropped(finder, DropReason::overflow), 0U);
  EXPECT_EQ(dropped(finder, DropReason::late), 0U);
}

TEST(StopFinder, CountsPointsThatComeAfterTheirStopWasClosed) {
  const RigMotion motion = three_stops();
  std::vector<Event> events = record(motion, 0.0);
  CollectingSink sink;
  StopFinder finder(StopOptions{}, sink);
  const double in_first_stop = 0.5 * (motion.rests()[0].start_s + motion.rests()[0].end_s);
  events.insert(events.end() - static_cast<std::ptrdiff_t>(events.size() / 4),
                {0.0, false, {}, timed_batch(1, in_first_stop, 50, 1e-4)});
  feed(finder, events);
  EXPECT_EQ(dropped(finder, DropReason::late), 50U);
  EXPECT_EQ(sink.stops.size(), 3U);
}

TEST(StopFinder, KeepsItsMemoryBoundAndCountsTheOverflow) {
  const std::vector<Event> events = record(three_stops(), 0.0);
  CollectingSink sink;
  StopOptions options;
  options.max_held_points = 16384;  // a block: 0.8 s of both sensors need two
  StopFinder finder(options, sink);
  feed(finder, events);
  EXPECT_GT(dropped(finder, DropReason::overflow), 0U);
  EXPECT_EQ(sink.stops.size(), 3U);
}

TEST(StopFinder, SplitsABatchLargerThanItsBlocks) {
  RigMotion motion;
  motion.rest(4.0);
  Random random(1);
  CollectingSink sink;
  StopFinder finder(StopOptions{}, sink);
  finder.add_points(timed_batch(3, 1.0, 60000, 1e-5));
  for (const ImuSample& sample : read_gyro(motion, GyroModel{}, random)) finder.add_imu(sample);
  finder.flush();
  ASSERT_EQ(sink.stops.size(), 1U);
  EXPECT_EQ(sink.stops[0].record.points.at(3), 60000U);
}

TEST(StopFinder, KeepsNoPointsWhereTheUnitNeverSpeaks) {
  CollectingSink sink;
  StopFinder finder(StopOptions{}, sink);
  for (int i = 0; i < 1000; ++i) finder.add_points(timed_batch(1, 0.01 * i, 100, 1e-4));
  finder.flush();
  EXPECT_TRUE(sink.stops.empty());
  EXPECT_EQ(dropped(finder, DropReason::before_first_stop), 100000U);
  EXPECT_EQ(finder.gyro_figures().imu_samples, 0U);
}

}  // namespace
}  // namespace rigcal
