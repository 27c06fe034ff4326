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

StillStop rest_of_points(double start_s, double end_s, int sensor, const Vector3d& turn_deg) {
  StillStop rest;
  rest.stop = {0, to_stamp(start_s), to_stamp(end_s) - 1};
  rest.sensor = sensor;
  rest.R_previous_this = exp_so3(to_rad(1.0) * turn_deg);
  rest.rotation_sigma_rad = to_rad(0.01);
  return rest;
}

StillStop turned_by_gyro(int index, double start_s, double end_s, double turn_deg) {
  StillStop stop;
  stop.stop = {index, to_stamp(start_s), to_stamp(end_s) - 1};
  stop.sensor = 0;
  stop.R_previous_this = exp_so3(to_rad(turn_deg) * Vector3d::UnitZ());
  stop.rotation_sigma_rad = to_rad(0.01);
  return stop;
}

// The gyro's first stop lasts from 10 to 20 s and creeps by 0.1 deg a second, which the gyro takes for its bias; the
// points find rests of a second in it, the last of which they tell of when it is long over.
CollectingListener creeping_stop(const StopOptions& options, const std::vector<StillStop>& rests) {
  CollectingListener told;
  CreepGuard guard(options, told);
  guard.not_still_until(to_stamp(10.0), DropReason::moving);
  guard.points().stop_ended(rest_of_points(10.0, 12.0, 0, Vector3d::Zero()));
  for (double until_s = 10.5; until_s < 20.0; until_s += 0.025) guard.still_until(to_stamp(until_s), 0);
  for (std::size_t i = 0; i + 1 < rests.size(); ++i) guard.points().stop_ended(rests[i]);
  guard.not_still_until(to_stamp(20.0), DropReason::moving);
  guard.stop_ended(turned_by_gyro(0, 10.0, 20.0, 0.0));
  if (!rests.empty()) guard.points().stop_ended(rests.back());
  guard.points().stop_ended(rest_of_points(25.0, 29.0, 0, {0.0, 0.0, 1.0}));
  for (double until_s = 25.5; until_s < 29.0; until_s += 0.025) guard.still_until(to_stamp(until_s), 1);
  guard.not_still_until(to_stamp(29.0), DropReason::moving);
  guard.stop_ended(turned_by_gyro(1, 25.0, 29.0, 18.0));
  guard.stop_ended(turned_by_gyro(2, 31.0, 35.0, 18.0));
  return told;
}

double turn_deg(const StillStop& stop) { return to_deg(log_so3(stop.R_previous_this).z()); }

TEST(CreepGuard, PutsTheCreepThatIsLeftOutBeforeTheTurnThatFollows) {
  const CollectingListener told = creeping_stop(
      {}, {rest_of_points(13.0, 15.0, 0, {0.0, 0.0, 0.3}), rest_of_points(16.0, 20.0, 0, {0.0, 0.0, 0.4})});
  ASSERT_EQ(told.stops.size(), 3U);
  EXPECT_EQ(told.stops[0].end, StopEnd::creep);
  EXPECT_NEAR(turn_deg(told.stops[1]), 18.7, 1e-6);
  EXPECT_NEAR(to_deg(told.stops[1].rotation_sigma_rad), 0.01 * std::sqrt(3.0), 1e-6);
  EXPECT_NEAR(turn_deg(told.stops[2]), 18.0, 1e-6) << "once";
}

TEST(CreepGuard, CarriesCreepOverToTheGyroByTheTablesAxis) {
  StopOptions options;
  options.turn_axes = {{0, Vector3d::UnitZ()}, {1, -Vector3d::UnitX()}};
  const std::vector<StillStop> rests = {rest_of_points(13.0, 20.0, 1, {-0.5, 0.2, 0.0})};
  EXPECT_NEAR(turn_deg(creeping_stop(options, rests).stops[1]), 18.5, 1e-6);
  const StillStop unknown = creeping_stop({}, rests).stops[1];
  EXPECT_NEAR(turn_deg(unknown), 18.0, 1e-6);
  EXPECT_GE(to_deg(unknown.rotation_sigma_rad), 0.5) << "the turn is as unsure as it crept";
}

TEST(CreepGuard, WidensTheSigmaWhereNothingTellsOfTheCreep) {
  const StillStop next = creeping_stop({}, {}).stops[1];
  EXPECT_NEAR(turn_deg(next), 18.0, 1e-6);
  EXPECT_NEAR(to_deg(next.rotation_sigma_rad), 8.0 * to_deg(StopOptions::creep_limit_rad_s), 0.01);
}

}  // namespace
}  // namespace rigcal
