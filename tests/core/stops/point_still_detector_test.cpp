#include "core/stops/point_still_detector.h"

#include <gmock/gmock.h>

#include "tests/core/stops/point_run.h"

namespace rigcal {
namespace {

// What the noise of the points permits: a LiDAR of 40 000 points/s shows turns from about 0.05 deg on, and the rest of
// a swing that it does not show has 0.2 s to fade.
constexpr double most_rotation_deg = 0.03;
constexpr double most_translation_mm = 0.2;

struct Found {
  std::vector<StillStop> stops;
  PointStillFigures figures;
};

Found find(const PointRun& run) {
  const StopOptions options{.source = StopSource::points, .turn_axes = run.turn_axes()};
  CollectingListener listener;
  PointStillDetector detector(options, listener);
  run.play([&](const PointBatch& batch) { detector.add(batch); });
  detector.flush();
  return {listener.stops, detector.figures()};
}

double start_of(const StillStop& stop) { return to_seconds(stop.stop.start_ns); }
double end_of(const StillStop& stop) { return to_seconds(stop.stop.end_ns); }

void expect_quiet(const PointRun& run, const StillStop& stop, double rotation_deg = most_rotation_deg,
                  double translation_mm = most_translation_mm) {
  const Deviation off = deviation_in(run.motion(), start_of(stop), end_of(stop));
  EXPECT_LE(off.rotation_deg, rotation_deg)
      << "stop " << stop.stop.index << ": " << start_of(stop) << " .. " << end_of(stop);
  EXPECT_LE(off.translation_mm, translation_mm) << "stop " << stop.stop.index;
}

// Every stop of the run is found once, and the share `kept` of it from when its swing has settled on.
void expect_all_found(const PointRun& run, const PointRun::Options& options, const std::vector<StillStop>& stops,
                      double kept = 0.8, double rotation_deg = most_rotation_deg) {
  ASSERT_EQ(static_cast<int>(stops.size()), run.motion().stop_count());
  for (std::size_t k = 0; k < stops.size(); ++k) {
    const int stop = static_cast<int>(k);
    const bool swings = k > 0;
    const double settled_s = run.motion().stop_start_s(stop) + (swings ? settling_s(options.turntable) : 0.0);
    const double from_s = std::max(settled_s, options.lead_s);
    const double until_s = std::min(run.motion().stop_end_s(stop), run.end_s());
    EXPECT_GE(start_of(stops[k]), run.motion().stop_start_s(stop)) << "stop " << k;
    EXPECT_LE(end_of(stops[k]), run.motion().stop_end_s(stop) + 0.05) << "stop " << k;
    EXPECT_GE(end_of(stops[k]) - start_of(stops[k]), kept * (until_s - from_s))
        << "stop " << k << ": " << start_of(stops[k]) << " .. " << end_of(stops[k]) << " of " << from_s << " .. "
        << until_s;
    expect_quiet(run, stops[k], rotation_deg);
  }
}

struct Case {
  const char* name;
  const char* scene;
  std::vector<std::size_t> lidars;
  double most_rotation_deg;  ///< In a room the same noise of ranges hides larger turns.
};
class PointStillDetectorScenes : public testing::TestWithParam<Case> {};

TEST_P(PointStillDetectorScenes, FindsTheStopsOfATurntableOnceEachWithoutMotionOrSwing) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PointRun::Options options;
    options.scene = GetParam().scene;
    options.lidars = GetParam().lidars;
    options.seed = seed;
    options.shots_per_s = 40'000.0;
    options.turntable.stops = 4;
    const PointRun run(options);
    const Found found = find(run);
    expect_all_found(run, options, found.stops, 0.8, GetParam().most_rotation_deg);
    EXPECT_LE(to_deg(found.figures.resolution_rad), 0.1);
  }
}
INSTANTIATE_TEST_SUITE_P(PointStillDetector, PointStillDetectorScenes,
                         testing::Values(Case{"RoomAviaAndMid40", "room", {0, 1}, 0.06},
                                         Case{"RoomAll", "room", {0, 1, 2, 3}, 0.06},
                                         Case{"CourtyardAviaAndMid40", "courtyard", {0, 1}, 0.03},
                                         Case{"CourtyardMid40s", "courtyard", {1, 2, 3}, 0.03}),
                         [](const auto& test) { return test.param.name; });

// Three small views of a room, through which people walk: a stop may come in two, which then stand in one place.
TEST(PointStillDetector, LosesAndInventsNoStopWithSmallViewsOnly) {
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    PointRun::Options options;
    options.lidars = {1, 2, 3};
    options.seed = seed;
    options.shots_per_s = 40'000.0;
    options.turntable.stops = 4;
    const PointRun run(options);
    std::vector<double> kept_s(4, 0.0);
    for (const StillStop& stop : find(run).stops) {
      expect_quiet(run, stop, 0.08, 0.25);
      for (int k = 0; k < 4; ++k) {
        if (start_of(stop) > run.motion().stop_start_s(k) && end_of(stop) < run.motion().stop_end_s(k) + 0.05) {
          kept_s[static_cast<std::size_t>(k)] += end_of(stop) - start_of(stop);
        }
      }
    }
    EXPECT_THAT(kept_s, testing::Each(testing::Ge(0.8)));
  }
}

PointRun::Options courtyard(int stops, std::uint64_t seed = 1) {
  PointRun::Options options;
  options.scene = "courtyard";
  options.seed = seed;
  options.turntable.stops = stops;
  return options;
}

TEST(PointStillDetector, FindsStopsOfOneSecond) {
  PointRun::Options options = courtyard(6);
  options.turntable.dwell_s = 1.0;
  options.turntable.swing_rad = 5e-4;
  options.shots_per_s = 40'000.0;
  const PointRun run(options);
  expect_all_found(run, options, find(run).stops, 0.7);
}

TEST(PointStillDetector, FindsAStopOfThirtySecondsAmongShortOnes) {
  PointRun::Options options = courtyard(3);
  options.turntable.initial_still_s = 28.0;
  options.lidars = {0};
  const PointRun run(options);
  expect_all_found(run, options, find(run).stops, 0.75);
}

TEST(PointStillDetector, TakesAnOvershootAndItsReturnForMotion) {
  for (const double overshoot_deg : {0.3, 2.0}) {
    PointRun::Options options = courtyard(4);
    options.turntable.overshoot_rad = to_rad(overshoot_deg);
    const PointRun run(options);
    expect_all_found(run, options, find(run).stops);
  }
}

TEST(PointStillDetector, FindsStopsThatTheRecordingsEndsCut) {
  PointRun::Options options = courtyard(3);
  options.lead_s = 1.5;
  options.tail_s = 1.0;
  const PointRun run(options);
  const std::vector<StillStop> stops = find(run).stops;
  expect_all_found(run, options, stops);
  EXPECT_EQ(stops.back().end, StopEnd::stream);
}

TEST(PointStillDetector, BeginsInTheMiddleOfATurn) {
  PointRun::Options options = courtyard(3);
  options.lead_s = 3.7;  // the first turn lasts from 3.0 to 4.5
  const PointRun run(options);
  const std::vector<StillStop> stops = find(run).stops;
  ASSERT_EQ(stops.size(), 2U);
  EXPECT_GE(start_of(stops[0]), 4.5);
  for (const StillStop& stop : stops) expect_quiet(run, stop);
}

// 0.02 deg/s is an arc minute and more in every second: no stop may carry it on for long.
TEST(PointStillDetector, EndsAStopThatSlowlyCreepsAway) {
  PointRun::Options options = courtyard(2);
  options.turntable.creep_rad_per_s = to_rad(0.02);
  options.turntable.dwell_s = 8.0;
  options.shots_per_s = 40'000.0;
  const PointRun run(options);
  const std::vector<StillStop> stops = find(run).stops;
  ASSERT_GE(stops.size(), 4U);
  for (std::size_t k = 0; k < stops.size(); ++k) {
    expect_quiet(run, stops[k], 0.03, 0.3);
    const bool same_dwell = k > 0 && (start_of(stops[k]) < 9.0 || start_of(stops[k - 1]) > 10.5);
    if (!same_dwell) continue;
    ASSERT_TRUE(stops[k].rotation_known);
    EXPECT_LE(to_deg(log_so3(stops[k].R_previous_this).norm()), 0.12);
  }
}

TEST(PointStillDetector, CutsAStopWhereItIsBumped) {
  for (const double bump_deg : {0.1, 0.5}) {
    PointRun::Options options = courtyard(3);
    options.turntable.dwell_s = 4.0;
    options.turntable.bumps = {{1, 2.0, to_rad(bump_deg)}};
    options.shots_per_s = 40'000.0;
    const PointRun run(options);
    const std::vector<StillStop> stops = find(run).stops;
    ASSERT_EQ(stops.size(), 4U) << bump_deg;
    for (const StillStop& stop : stops) expect_quiet(run, stop);
    EXPECT_FALSE(stops[1].rotation_known);
    ASSERT_TRUE(stops[2].rotation_known);
    EXPECT_NEAR(to_deg(log_so3(stops[2].R_previous_this).norm()), bump_deg, 0.03);
    const SE3 before = run.motion().T_scene_base_settled(0.5 * (start_of(stops[1]) + end_of(stops[1])));
    const SE3 after = run.motion().T_scene_base_settled(0.5 * (start_of(stops[2]) + end_of(stops[2])));
    if (stops[2].sensor == 0) {
      EXPECT_LE(to_deg(rotation_distance(stops[2].R_previous_this, before.R.transpose() * after.R)), 0.03);
    }
    EXPECT_FALSE(stops[3].rotation_known);
  }
}

// The slots start anew after a silence of more than two seconds: what comes then is told from the stop before it, not
// from the one before that, which may look alike and stood elsewhere.
TEST(PointStillDetector, TellsARestThatGoesOnAfterALongSilenceFromTheStopBeforeIt) {
  PointRun::Options options = courtyard(3);
  options.turntable.dwell_s = 7.0;
  options.shots_per_s = 40'000.0;
  const PointRun run(options);
  const double silent_s = run.motion().stop_start_s(1) + 2.0;
  CollectingListener listener;
  PointStillDetector detector({.source = StopSource::points, .turn_axes = run.turn_axes()}, listener);
  run.play([&](const PointBatch& batch) {
    const double t = to_seconds(batch.stamp_ns);
    if (t < silent_s || t > silent_s + 2.5) detector.add(batch);
  });
  detector.flush();
  ASSERT_EQ(listener.stops.size(), 4U);
  EXPECT_EQ(listener.stops[1].end, StopEnd::silence);
  EXPECT_FALSE(listener.stops[1].rotation_known);
  ASSERT_TRUE(listener.stops[2].rotation_known);
  EXPECT_LE(to_deg(log_so3(listener.stops[2].R_previous_this).norm()), 0.03);
}

TEST(PointStillDetector, StandsAVibrationThatTheCalibrationStands) {
  for (const double hz : {5.0, 12.0, 30.0}) {
    SCOPED_TRACE(std::to_string(hz) + " Hz");
    PointRun::Options options = courtyard(3);
    options.turntable.vibration = {to_rad(hz < 10.0 ? 0.03 : 0.04), hz};
    options.shots_per_s = 40'000.0;
    const PointRun run(options);
    expect_all_found(run, options, find(run).stops, 0.8, 0.07);
  }
}

TEST(PointStillDetector, SaysThatItIsBlindInAnOpenField) {
  PointRun::Options options;
  sim::Scene field;
  field.materials.emplace_back();
  field.has_ground = true;
  field.ground_height = -1.5;
  for (const double x : {12.0, -20.0, 35.0})
    field.cylinders.push_back({{x, 0.5 * x, -1.5}, {0.0, 0.0, 1.0}, 4.0, 0.05});
  options.own_scene = field;
  options.turntable.stops = 3;
  const PointRun run(options);
  const Found found = find(run);
  EXPECT_TRUE(found.stops.empty());
  EXPECT_GE(found.figures.blind_s, 2.0);
}

TEST(PointStillDetector, GivesTheSameWhetherOneLidarComesLate) {
  const PointRun run(courtyard(2));
  std::vector<PointBatch> batches;
  run.play([&](const PointBatch& batch) { batches.push_back(batch); });
  const auto stops_with_lag = [&](std::int64_t lag_ns) {
    std::vector<PointBatch> order = batches;
    std::stable_sort(order.begin(), order.end(), [&](const PointBatch& a, const PointBatch& b) {
      return a.stamp_ns + (a.sensor == 1 ? lag_ns : 0) < b.stamp_ns + (b.sensor == 1 ? lag_ns : 0);
    });
    CollectingListener listener;
    PointStillDetector detector({.source = StopSource::points}, listener);
    for (const PointBatch& batch : order) detector.add(batch);
    detector.flush();
    return listener.stops;
  };
  const std::vector<StillStop> prompt = stops_with_lag(0);
  const std::vector<StillStop> late = stops_with_lag(300'000'000);
  ASSERT_EQ(prompt.size(), 2U);
  ASSERT_EQ(late.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    EXPECT_EQ(late[k].stop.start_ns, prompt[k].stop.start_ns);
    EXPECT_EQ(late[k].stop.end_ns, prompt[k].stop.end_ns);
  }
}

// Batches of any time and any place: nothing grows, nothing breaks, and verdicts go forward.
TEST(PointStillDetector, OutlivesNonsense) {
  class Watcher final : public StillListener {
   public:
    void not_still_until(std::int64_t, DropReason) override {}
    void still_until(std::int64_t until_ns, int stop) override {
      EXPECT_GE(stop, stop_);
      stop_ = stop;
      until_ns_ = until_ns;
    }
    void stop_ended(const StillStop& stop) override {
      EXPECT_EQ(stop.stop.index, ended_ + 1);
      ended_ = stop.stop.index;
      EXPECT_LE(stop.stop.start_ns, stop.stop.end_ns);
    }

   private:
    int stop_ = 0;
    int ended_ = -1;
    std::int64_t until_ns_ = 0;
  };
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    Watcher watcher;
    PointStillDetector detector({.source = StopSource::points}, watcher);
    std::int64_t stamp_ns = start_of_time_ns;
    const double wildness = random.uniform();
    for (int i = 0; i < 3000; ++i) {
      PointBatch batch;
      batch.sensor = static_cast<int>(random.below(seed % 3 == 0 ? 100 : 3)) - (seed % 5 == 0 ? 1 : 0);
      batch.shot_interval_ns = random.uniform() < 0.05 * wildness ? random.uniform(-1e12, 1e15) : 1e4;
      if (random.uniform() < 0.02 * wildness) stamp_ns += static_cast<std::int64_t>(random.uniform(-5e9, 5e9));
      if (random.uniform() < 0.001 * wildness) stamp_ns = static_cast<std::int64_t>(random.next_u64());
      if (random.uniform() < 0.001 * wildness) stamp_ns = start_of_time_ns;
      const std::int64_t limit = std::numeric_limits<std::int64_t>::max() / 2;
      stamp_ns = std::clamp(stamp_ns, -limit, limit) + 3'000'000;
      batch.stamp_ns = stamp_ns;
      const std::uint64_t count = random.below(seed % 4 == 0 ? 5000 : 60);
      const bool wild = random.uniform() < 0.3 * wildness;
      for (std::uint64_t k = 0; k < count; ++k) {
        const double size = wild ? std::pow(10.0, random.uniform(-30.0, 38.0)) : 5.0;
        const auto any = [&] { return static_cast<float>(size * random.uniform(-1.0, 1.0)); };
        batch.points.push_back(
            {any(), any(), wild ? any() : 2.0F, 0, 0, static_cast<std::uint16_t>(random.below(65536))});
        if (!wild) batch.points.back().shot = static_cast<std::uint16_t>(k);
      }
      detector.add(batch);
    }
    detector.flush();
    EXPECT_LE(detector.figures().stops, 40);
  }
}

}  // namespace
}  // namespace rigcal
