#include "core/quality/comparison.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "core/base/random.h"
#include "core/quality/lidar_quality.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

using testing::HasSubstr;

constexpr int stops = 4;
constexpr int lidars = 3;
constexpr double noise_m = 0.01;

// What a calibration of a rig gives: planes seen with noise, solved, with their covariances. `rig` is told from its
// first LiDAR, the result from `base`.
CalibrationResult calibrated(const std::vector<SE3>& rig, std::uint64_t seed, int base = 0) {
  Random random(seed);
  RigState truth;
  for (const SE3& T : rig) truth.T_base_sensor.push_back(rig[static_cast<std::size_t>(base)].inverse() * T);
  truth.T_G_base.emplace_back();
  for (int j = 1; j < stops; ++j) truth.T_G_base.push_back(random_pose(random, 0.6, 0.2));
  std::vector<PlaneFeature> features = make_plane_features(truth, 20, 30, noise_m, random);
  for (PlaneFeature& feature : features) {
    for (PlaneObservation& o : feature.observations) {
      o.offset_variance = noise_m * noise_m / o.N;
      const Vector3d n = truth.T_G_sensor(o.stop, o.lidar).R.transpose() * feature.normal_G;
      o.scatter -= o.N * noise_m * noise_m * n * n.transpose();
    }
  }
  ParameterLayout layout(stops, lidars);
  for (int j = 1; j < stops; ++j) layout.free_stop(j);
  for (int i = 0; i < lidars; ++i) {
    if (i != base) layout.free_lidar(i);
  }
  RigState state = disturbed(truth, random, 0.002, 0.01);
  const AdjustOptions options;
  adjust(features, layout, options, state);
  const LidarCovariances covariances = lidar_covariances({features, state, layout, options});
  CalibrationResult result;
  result.base = base == 0 ? "base" : "lidar" + std::to_string(base);
  for (int i = 0; i < lidars; ++i) {
    SensorResult sensor;
    sensor.name = i == 0 ? "base" : "lidar" + std::to_string(i);
    sensor.status = Status::good;
    sensor.T_base_sensor = state.T_base_sensor[static_cast<std::size_t>(i)];
    sensor.covariance = covariances.with_priors[static_cast<std::size_t>(i)];
    result.sensors.push_back(sensor);
  }
  return result;
}

std::vector<SE3> mounted(Random& random) {
  return {SE3{}, random_pose(random, 0.8, 0.2), random_pose(random, 0.8, 0.2)};
}

SE3 bump(Random& random, double rotation_rad, double translation_m) {
  Vector6d xi;
  for (int k = 0; k < 6; ++k) xi[k] = random.normal();
  xi.head<3>() *= rotation_rad / xi.head<3>().norm();
  xi.tail<3>() *= translation_m / xi.tail<3>().norm();
  return SE3::exp(xi);
}

// How many of 100 pairs of runs say of lidar1 that it moved; and of anything else.
struct Counts {
  int moved = 0;
  int others = 0;
};

Counts count(double rotation_rad, double translation_m) {
  Counts counts;
  Vector6d variances = Vector6d::Zero();
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(1000 + seed);
    std::vector<SE3> rig = mounted(random);
    const CalibrationResult before = calibrated(rig, 2 * seed);
    if (rotation_rad + translation_m > 0.0) rig[1] = rig[1] * bump(random, rotation_rad, translation_m);
    variances += before.sensors[1].covariance.diagonal() / 100.0;
    const auto comparison = compare_results(before, calibrated(rig, 2 * seed + 1));
    EXPECT_TRUE(comparison);
    counts.moved += comparison->sensors[0].verdict == MoveVerdict::moved ? 1 : 0;
    counts.others += comparison->sensors[1].verdict == MoveVerdict::moved || comparison->base_moved ? 1 : 0;
  }
  std::printf("bump of %.1f mm and %.2f deg, sigma %.2f mm and %.4f deg: moved in %d of 100, another in %d\n",
              1e3 * translation_m, to_deg(rotation_rad), 1e3 * std::sqrt(variances.tail<3>().mean()),
              to_deg(std::sqrt(variances.head<3>().mean())), counts.moved, counts.others);
  return counts;
}

TEST(CompareResults, SeesABumpOfFiveMillimetres) {
  const Counts counts = count(0.0, 0.005);
  EXPECT_GE(counts.moved, 95);
  EXPECT_LE(counts.others, 5);
}

TEST(CompareResults, SeesABumpOfATenthOfADegree) {
  const Counts counts = count(to_rad(0.1), 0.0);
  EXPECT_GE(counts.moved, 95);
  EXPECT_LE(counts.others, 5);
}

TEST(CompareResults, SeesNoneWhereThereIsNone) {
  const Counts counts = count(0.0, 0.0);
  EXPECT_LE(counts.moved + counts.others, 5);
}

TEST(CompareResults, KnowsTheBaseByAllOthersMovingAlike) {
  Random random(5);
  std::vector<SE3> rig = mounted(random);
  const CalibrationResult before = calibrated(rig, 1);
  const SE3 base = bump(random, to_rad(0.3), 0.02);
  for (int i = 1; i < lidars; ++i) rig[static_cast<std::size_t>(i)] = base.inverse() * rig[static_cast<std::size_t>(i)];
  const auto moved = compare_results(before, calibrated(rig, 2));
  ASSERT_TRUE(moved);
  EXPECT_TRUE(moved->base_moved);
  EXPECT_EQ(comparison_sentence(*moved), "base, the base, moved: all others moved alike, seen from it.");
  // Both moved, each in its own way.
  rig[1] = rig[1] * bump(random, to_rad(0.3), 0.02);
  const auto apart = compare_results(before, calibrated(rig, 3));
  ASSERT_TRUE(apart);
  EXPECT_FALSE(apart->base_moved);
}

TEST(CompareResults, SaysWhatItCannotCompare) {
  Random random(5);
  const std::vector<SE3> rig = mounted(random);
  CalibrationResult a = calibrated(rig, 1);
  CalibrationResult b = calibrated(rig, 2);
  b.sensors[1].T_base_sensor.reset();
  b.sensors[1].status = Status::failed;
  b.sensors.push_back(b.sensors[2]);
  b.sensors.back().name = "new";
  const auto comparison = compare_results(a, b);
  ASSERT_TRUE(comparison);
  ASSERT_EQ(comparison->sensors.size(), 3U);
  EXPECT_EQ(comparison->sensors[0].why_not, "it failed in the second result");
  EXPECT_EQ(comparison->sensors[2].why_not, "the first result does not have it");
  EXPECT_EQ(comparison_sentence(*comparison), "Nothing moved: 1 sensor is where it was; 2 sensors are not compared.");
}

TEST(CompareResults, OfTwoBasesAreToldFromASensorOfBoth) {
  Counts still;
  int of_5_mm = 0;
  int of_10_mm = 0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    Random random(3000 + seed);
    std::vector<SE3> rig = mounted(random);
    const CalibrationResult before = calibrated(rig, 2 * seed);
    const auto same = compare_results(before, calibrated(rig, 2 * seed + 1, 2));
    ASSERT_TRUE(same) << same.error().message();
    EXPECT_EQ(same->base, "base");
    ASSERT_EQ(same->sensors.size(), 2U);
    for (const SensorMove& move : same->sensors) still.others += move.verdict == MoveVerdict::same ? 0 : 1;
    const auto sees = [&](double bump_m) {
      std::vector<SE3> bumped = rig;
      bumped[1] = rig[1] * bump(random, 0.0, bump_m);
      const auto moved = compare_results(before, calibrated(bumped, 2 * seed + 1, 2));
      EXPECT_TRUE(moved);
      return moved && moved->sensors[0].verdict == MoveVerdict::moved;
    };
    of_10_mm += sees(0.010) ? 1 : 0;
    of_5_mm += sees(0.005) ? 1 : 0;
  }
  std::printf("two bases: bumps of 5 mm seen in %d of 100, of 10 mm in %d, without a bump in %d\n", of_5_mm, of_10_mm,
              still.others);
  EXPECT_LE(still.others, 5);
  // Twice as much as where the base is the same: the errors of both sensors are in it.
  EXPECT_GE(of_10_mm, 95);
}

TEST(CompareResults, OfTwoBasesSayFromWhichSensor) {
  Random random(5);
  const std::vector<SE3> rig = mounted(random);
  const CalibrationResult a = calibrated(rig, 1);
  const CalibrationResult b = calibrated(rig, 2, 1);
  const auto comparison = compare_results(a, b);
  ASSERT_TRUE(comparison);
  EXPECT_EQ(comparison_sentence(*comparison),
            "Nothing moved: 2 sensors are where they were; all as seen from base, since the results have two bases, "
            "base and lidar1.");
  // The second one's base where the first one's failed there, else any that both have.
  CalibrationResult c = b;
  c.sensors[0].T_base_sensor.reset();
  const auto by_second = compare_results(a, c);
  ASSERT_TRUE(by_second);
  EXPECT_EQ(by_second->base, "lidar1");
  CalibrationResult d = a;
  d.sensors[1].T_base_sensor.reset();
  const auto by_other = compare_results(d, c);
  ASSERT_TRUE(by_other);
  EXPECT_EQ(by_other->base, "lidar2");
  EXPECT_EQ(comparison_sentence(*by_other),
            "Nothing could be compared; all as seen from lidar2, since the results have two bases, base and lidar1.");
  c.sensors[2].T_base_sensor.reset();
  const auto by_none = compare_results(d, c);
  ASSERT_FALSE(by_none);
  EXPECT_THAT(by_none.error().message(), HasSubstr("no sensor that both know the place of"));
}

TEST(ComparisonSentence, NamesWhatMovedAndByHowMuch) {
  ResultComparison comparison;
  comparison.base = "avia";
  SensorMove moved{"left", MoveVerdict::moved, {}, Vector6d::Zero(), 16.04};
  moved.xi << to_rad(0.012), 0.0, 0.0, 0.0, 0.0051, 0.0;
  comparison.sensors = {moved, {"right", MoveVerdict::same, {}, Vector6d::Zero(), 0.9}};
  EXPECT_EQ(
      comparison_sentence(comparison),
      "left moved by 5.1 mm and 0.012 degrees (16.0 times what both results are sure of); 1 other is where it was.");
}

}  // namespace
}  // namespace rigcal
