#include "core/stops/creep_guard.h"

#include <gmock/gmock.h>

#include "core/base/seconds.h"
#include "tests/core/stops/rig_motion.h"

namespace rigcal {
namespace {

// A gyro that finds one stop from 10 to 14 s, where the points see the rig leave its place as told.
class GuardedStop {
 public:
  struct Left {
    double at_s;
    double known_s;  ///< When the points' verdict comes, by the gyro's.
  };

  FoundStop play(const std::vector<Left>& lefts) {
    for (double t = 9.0; t < 15.0; t += 0.01) cutter_.add(timed_batch(1, t, 100, 1e-4));
    guard_.not_still_until(to_stamp(10.0), DropReason::moving);
    for (int i = 0; i <= 140; ++i) {
      const double until_s = 10.5 + 0.025 * i;
      for (const Left& left : lefts) {
        if (std::abs(left.known_s - until_s) < 1e-9) tell(left.at_s);
      }
      guard_.still_until(to_stamp(until_s), 0);
    }
    StillStop stop;
    stop.stop = {0, to_stamp(10.0), to_stamp(14.0) - 1};
    guard_.not_still_until(to_stamp(14.05), DropReason::moving);
    guard_.stop_ended(stop);
    cutter_.flush();
    return sink_.stops.at(0);
  }

 private:
  void tell(double left_s) {
    StillStop rest;
    rest.stop = {0, to_stamp(9.0), to_stamp(left_s) - 1};
    guard_.points().stop_ended(rest);
  }

  CollectingSink sink_;
  PatchCutter cutter_{4'000'000, sink_};
  CreepGuard guard_{StopOptions{}, cutter_};
};

void expect_points_between(const FoundStop& stop, double start_s, double end_s) {
  EXPECT_NEAR(to_seconds(stop.record.stop.start_ns), start_s, 1e-6);
  EXPECT_NEAR(to_seconds(stop.record.stop.end_ns), end_s, 1e-6);
  EXPECT_NEAR(stop.times_s.at(1).front(), start_s, 2e-4);
  EXPECT_NEAR(stop.times_s.at(1).back(), end_s, 2e-4);
}

TEST(CreepGuard, KeepsTheWholeStopWhereThePointsSeeNothing) {
  expect_points_between(GuardedStop().play({}), 10.0, 14.0);
}

TEST(CreepGuard, EndsAStopWhereTheRigLeaves) {
  const FoundStop stop = GuardedStop().play({{12.0, 12.2}});
  expect_points_between(stop, 10.0, 12.0);
  EXPECT_EQ(stop.record.end, StopEnd::creep);
}

// Otherwise a patch would hold two places: the first 0.3 s, and what comes half a second later.
TEST(CreepGuard, BeginsAStopAnewWhereTheRigLeavesTooEarly) {
  const FoundStop stop = GuardedStop().play({{10.3, 10.6}});
  expect_points_between(stop, 10.8, 14.0);
  EXPECT_EQ(stop.record.end, StopEnd::motion);
}

TEST(CreepGuard, CutsWhatBeganAnewWhereTheRigLeavesAgain) {
  const FoundStop stop = GuardedStop().play({{10.3, 10.6}, {11.1, 11.4}, {12.9, 13.2}});
  expect_points_between(stop, 11.6, 12.9);
  EXPECT_EQ(stop.record.end, StopEnd::creep);
}

}  // namespace
}  // namespace rigcal
