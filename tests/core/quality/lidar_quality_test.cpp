#include "core/quality/lidar_quality.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/geometry/matrix6.h"
#include "core/planes/merge_planes.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

constexpr int stops = 5;
constexpr double sigma_m = 0.01;

// A rig of two LiDARs at five stops, planes all around it, solved from a disturbed start.
struct Solved {
  RigState truth;
  std::vector<PlaneFeature> features;
  RigState state;
  ParameterLayout layout{stops, 2};
  AdjustOptions options;

  explicit Solved(std::uint64_t seed) {
    Random random(seed);
    truth.T_G_base.emplace_back();
    for (int j = 1; j < stops; ++j) truth.T_G_base.push_back(random_pose(random, 0.6, 0.2));
    truth.T_base_sensor = {SE3{}, random_pose(random, 0.8, 0.2)};
    features = make_plane_features(truth, 25, 60, sigma_m, random);
    for (PlaneFeature& feature : features) {
      for (PlaneObservation& o : feature.observations) {
        o.offset_variance = sigma_m * sigma_m / o.N;
        // Every point's noise lies along the normal, so its share of the scatter is known.
        o.scatter -= o.N * sigma_m * sigma_m * normal_in_sensor(feature, o) * normal_in_sensor(feature, o).transpose();
      }
    }
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    layout.free_lidar(1);
    state = disturbed(truth, random, 0.002, 0.01);
  }

  [[nodiscard]] Vector3d normal_in_sensor(const PlaneFeature& feature, const PlaneObservation& o) const {
    return truth.T_G_sensor(o.stop, o.lidar).R.transpose() * feature.normal_G;
  }
  void solve() { ASSERT_TRUE(adjust(features, layout, options, state).converged); }
  [[nodiscard]] SolvedPlanes planes() const { return {features, state, layout, options}; }
};

TEST(LidarCovariances, HoldTheErrorsOverManyRuns) {
  double sum = 0.0;
  double chi2 = 0.0;
  constexpr int runs = 60;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    Solved run(seed);
    run.solve();
    const LidarCovariances c = lidar_covariances(run.planes());
    ASSERT_THAT(c.observable, testing::ElementsAre(1, 1));
    EXPECT_EQ(c.with_priors[0], Matrix6d::Zero());  // the base is what the others are measured from
    const Vector6d error = (run.truth.T_base_sensor[1].inverse() * run.state.T_base_sensor[1]).log();
    sum += error.dot(solve_symmetric6(c.with_priors[1], error)) / 6.0;
    chi2 += c.chi2;
  }
  // 360 degrees of freedom: one standard deviation of the mean is 0.075.
  EXPECT_NEAR(sum / runs, 1.0, 0.25);
  EXPECT_NEAR(chi2 / runs, 1.0, 0.15);
}

TEST(LidarCovariances, AreMeasuredAgainWhenTheNoiseIsLargerThanItWasSaidToBe) {
  Solved run(7);
  run.solve();
  const double said = translation_bound(lidar_covariances(run.planes()).with_priors[1]);
  for (PlaneFeature& feature : run.features) {
    for (PlaneObservation& o : feature.observations) o.offset_variance /= 9.0;
  }
  const LidarCovariances c = lidar_covariances(run.planes());
  EXPECT_GT(c.chi2, 6.0);
  EXPECT_GT(translation_bound(c.with_priors[1]), 2.0 * said);
}

// Planes that all three see at all stops.
struct ThreeLidars {
  explicit ThreeLidars(std::uint64_t seed) {
    Random random(seed);
    state.T_G_base.emplace_back();
    for (int j = 1; j < stops; ++j) state.T_G_base.push_back(random_pose(random, 0.6, 0.2));
    state.T_base_sensor = {SE3{}, random_pose(random, 0.8, 0.2), random_pose(random, 0.8, 0.2)};
    features = make_plane_features(state, 25, 60, sigma_m, random);
    for (PlaneFeature& feature : features) {
      for (PlaneObservation& o : feature.observations) o.offset_variance = sigma_m * sigma_m / o.N;
    }
  }
  RigState state;
  std::vector<PlaneFeature> features;
};

TEST(LidarCovariances, AreTheSameWhicheverLidarIsFixed) {
  const ThreeLidars rig(11);
  const RigState& state = rig.state;
  const std::vector<PlaneFeature>& features = rig.features;
  const auto covariances = [&](const RigState& at, int fixed, int base) {
    ParameterLayout layout(stops, 3);
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    for (int i = 0; i < 3; ++i) {
      if (i != fixed) layout.free_lidar(i);
    }
    return lidar_covariances({features, at, layout, {}}, base).with_priors;
  };
  RigState seen_from_1 = state;
  for (SE3& T : seen_from_1.T_G_base) T = T * state.T_base_sensor[1];
  for (SE3& T : seen_from_1.T_base_sensor) T = state.T_base_sensor[1].inverse() * T;
  const std::vector<Matrix6d> told = covariances(state, 0, 1);
  const std::vector<Matrix6d> solved = covariances(seen_from_1, 1, 1);
  EXPECT_EQ(told[1], Matrix6d::Zero());
  for (const std::size_t i : {0U, 2U}) {
    EXPECT_GT(solved[i].norm(), 0.0);
    EXPECT_LT((told[i] - solved[i]).norm(), 1e-6 * solved[i].norm()) << i;
  }
}

TEST(LidarCovariances, TellWhatOnlyAPriorFixes) {
  Solved run(8);
  // One plane at one stop: two shifts and a turn of the second LiDAR are open.
  std::vector<PlaneFeature> one{run.features.front()};
  std::erase_if(one[0].observations, [](const PlaneObservation& o) { return o.stop != 0; });
  run.layout = ParameterLayout(stops, 2);
  run.layout.free_lidar(1);
  run.options.lidar_priors = {std::nullopt, isotropic_prior(run.truth.T_base_sensor[1], to_rad(5.0), 0.1)};
  const LidarCovariances c = lidar_covariances({one, run.truth, run.layout, run.options});
  EXPECT_LT(translation_bound(c.with_priors[1]), 1.0);
  EXPECT_GT(translation_bound(c.data_only[1]), 100.0 * translation_bound(c.with_priors[1]));
}

TEST(LidarCovariances, NothingSeenIsNotObservable) {
  const RigState state{{SE3{}, SE3{}}, {SE3{}, SE3{}}};
  ParameterLayout layout(2, 2);
  layout.free_lidar(1);
  EXPECT_TRUE(lidar_covariances({{}, state, layout, {}}).observable.empty());
}

// Three LiDARs, the last of which sees no plane at all, one, or all but with numbers that are none.
TEST(LidarCovariances, JudgeEachLidarByWhatHoldsIt) {
  const ThreeLidars rig(12);
  const RigState& state = rig.state;
  std::vector<PlaneFeature> features = rig.features;
  ParameterLayout layout(stops, 3);
  for (int j = 1; j < stops; ++j) layout.free_stop(j);
  layout.free_lidar(1);
  layout.free_lidar(2);
  const double bound = translation_bound(lidar_covariances({features, state, layout, {}}).with_priors[1]);
  for (const std::size_t planes : {0U, 1U}) {
    std::vector<PlaneFeature> few = features;
    for (std::size_t k = planes; k < few.size(); ++k) {
      std::erase_if(few[k].observations, [](const PlaneObservation& o) { return o.lidar == 2; });
    }
    // Level in its own frame, so that parts of its information are zero to the bit; one stop, so that it has one plane.
    for (PlaneObservation& o : few[0].observations) {
      if (o.lidar == 2) o.scatter = (Matrix3d() << 20.0, 0.0, 0.0, 0.0, 20.0, 0.0, 0.0, 0.0, 0.0).finished();
    }
    std::erase_if(few[0].observations, [](const PlaneObservation& o) { return o.lidar == 2 && o.stop > 0; });
    const LidarCovariances c = lidar_covariances({few, state, layout, {}});
    EXPECT_THAT(c.observable, testing::ElementsAre(1, 1, 0)) << planes;
    EXPECT_LT(translation_bound(c.with_priors[1]), 2.0 * bound) << planes;
    // Told against the one that nothing holds nobody is known.
    EXPECT_THAT(lidar_covariances({few, state, layout, {}}, 2).observable, testing::ElementsAre(0, 0, 0)) << planes;
  }
  features[3].observations[4].mean.x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THAT(lidar_covariances({features, state, layout, {}}).observable, testing::ElementsAre(1, 0, 0));
}

TEST(HoldOutOfStops, IsOneWhereNoiseIsAllThereIs) {
  double sum = 0.0;
  constexpr int runs = 10;
  for (std::uint64_t seed = 20; seed < 20 + runs; ++seed) {
    Solved run(seed);
    run.solve();
    const HoldOut held = hold_out(run.planes(), 0, run.truth.T_base_sensor);
    EXPECT_EQ(held.normalised[0], 0.0);
    sum += held.normalised[1];
    EXPECT_LT((held.T_base_sensor[1].t - run.truth.T_base_sensor[1].t).norm(), 0.01);
  }
  EXPECT_NEAR(sum / runs, 1.0, 0.2);
}

// What a merged plane takes over of a leaf is still known of it.
TEST(HoldOutOfStops, IsTheSameWhateverAMergedPlaneTookOver) {
  Solved run(33);
  run.solve();
  const HoldOut whole = hold_out(run.planes(), 0, run.truth.T_base_sensor);
  constexpr double share = 0.9;
  const std::size_t leaves = run.features.size();
  for (std::size_t k = 0; k < leaves; ++k) {
    PlaneFeature merged = run.features[k];
    merged.merged = true;
    for (PlaneObservation& o : merged.observations) o.weight *= share;
    run.features[k].merged_share = share;
    for (PlaneObservation& o : run.features[k].observations) o.weight *= 1.0 - share;
    run.features.push_back(std::move(merged));
  }
  const HoldOut shared = hold_out(run.planes(), 0, run.truth.T_base_sensor);
  EXPECT_NEAR(shared.normalised[1], whole.normalised[1], 1e-3);
  EXPECT_NEAR(shared.rms_m[1], whole.rms_m[1], 1e-6);
}

// With three stops single leaves are held out, and what they tell stands in the sums of merged planes, too.
TEST(HoldOutOfStops, LeavesHeldOutLeavesOutOfMergedPlanes) {
  const auto extrinsics_without = [](double held_out_off_m) {
    Solved run(36);
    run.solve();
    std::vector<PlaneFeature> leaves;
    for (const PlaneFeature& plane : run.features) {
      const Vector3d aside = plane.normal_G.unitOrthogonal();
      for (const double by_m : {-1.5, -0.5, 0.5, 1.5}) {
        PlaneFeature& leaf = leaves.emplace_back(plane);
        std::erase_if(leaf.observations, [](const PlaneObservation& o) { return o.stop > 2; });
        leaf.center_G += by_m * aside;
        leaf.size_m = 1.0;
        const double off_m = leaves.size() % 5 == 3 ? held_out_off_m : 0.0;
        for (PlaneObservation& o : leaf.observations) {
          o.mean += run.truth.T_G_sensor(o.stop, o.lidar).R.transpose() * (by_m * aside);
          if (o.lidar == 1) o.mean += off_m * run.normal_in_sensor(plane, o);
        }
      }
    }
    std::vector<PlaneFeature> merged = merge_coplanar(leaves, {});
    EXPECT_GT(merged.size(), 10U);
    std::move(merged.begin(), merged.end(), std::back_inserter(leaves));
    run.features = std::move(leaves);
    run.layout = ParameterLayout(stops, 2);
    run.layout.free_stop(1);
    run.layout.free_stop(2);
    run.layout.free_lidar(1);
    const HoldOut held = hold_out(run.planes(), 0, run.truth.T_base_sensor);
    EXPECT_GT(held.rms_m[1], 0.9 * held_out_off_m);
    return held.T_base_sensor[1];
  };
  const SE3 found = extrinsics_without(0.0);
  EXPECT_LT((found.inverse() * extrinsics_without(0.1)).log().norm(), 1e-9);
}

// It lies on a plane in stops only that are held out.
TEST(HoldOutOfStops, IsOfTheOtherStopsAlsoWhereTheyHoldNothingOfOneLidar) {
  Solved run(34);
  run.truth.T_base_sensor.push_back(run.truth.T_base_sensor[1]);
  run.state = run.truth;
  run.layout = ParameterLayout(stops, 3);
  for (int j = 1; j < stops; ++j) run.layout.free_stop(j);
  run.layout.free_lidar(1);
  run.layout.free_lidar(2);
  for (PlaneFeature& feature : run.features) {
    for (std::size_t k = 0; k < feature.observations.size(); ++k) {
      PlaneObservation o = feature.observations[k];
      if (o.stop != 2 || o.lidar != 1) continue;
      o.lidar = 2;
      feature.observations.push_back(o);
    }
    // Bumped in the stop that is held out.
    for (PlaneObservation& o : feature.observations) {
      if (o.stop == 2 && o.lidar == 1) o.mean += Vector3d(0.02, -0.01, 0.02);
    }
  }
  run.solve();
  const HoldOut held = hold_out(run.planes(), 0, run.truth.T_base_sensor);
  EXPECT_LT((held.T_base_sensor[1].t - run.truth.T_base_sensor[1].t).norm(), 0.003);
  EXPECT_GT(held.normalised[1], 2.0);
}

// One that saw nothing in every fourth of all stops is checked by its own, one of two stops by every fifth plane.
TEST(HoldOutOfStops, IsByTheOwnStopsOfALidarThatSawNothingInTheOthers) {
  for (const int last : {4, 1}) {
    Solved run(35);
    for (PlaneFeature& feature : run.features) {
      std::erase_if(feature.observations,
                    [&](const PlaneObservation& o) { return o.lidar == 1 && (o.stop == 2 || o.stop > last); });
      for (PlaneObservation& o : feature.observations) {
        if (o.stop == 3 && o.lidar == 1) o.mean += Vector3d(0.02, -0.01, 0.02);
      }
    }
    run.solve();
    const HoldOut held = hold_out(run.planes(), 0, run.truth.T_base_sensor);
    if (last == 4) {
      EXPECT_GT(held.normalised[1], 2.0) << "bumped at the third of its four stops";
    } else {
      EXPECT_GT(held.normalised[1], 0.5);
      EXPECT_LT(held.normalised[1], 1.5);
    }
  }
}

TEST(HoldOutOfStops, SeesALidarThatWasBumped) {
  Solved run(31);
  for (PlaneFeature& feature : run.features) {
    for (PlaneObservation& o : feature.observations) {
      if (o.stop == 2 && o.lidar == 1) o.mean += Vector3d(0.02, -0.01, 0.02);
    }
  }
  run.solve();
  EXPECT_GT(hold_out(run.planes(), 0, run.truth.T_base_sensor).normalised[1], 2.0);
}

TEST(HoldOutOfStops, TellsHowMuchWorseTheGuessWas) {
  Solved run(32);
  run.solve();
  SE3 guess = run.truth.T_base_sensor[1];
  guess.t += Vector3d(0.1, 0.1, 0.1);
  const HoldOut held = hold_out(run.planes(), 0, {SE3{}, guess});
  EXPECT_LT(held.rms_m[1], 0.004);
  EXPECT_GT(held.start_rms_m[1], 0.05);
}

TEST(Bounds, AreThoseOfTheLargestAxis) {
  Matrix6d C = Matrix6d::Zero();
  C.diagonal() << 1e-6, 4e-6, 1e-6, 1e-4, 1e-4, 9e-4;
  // 95 % of the chi-square distribution with three degrees of freedom is 7.815.
  EXPECT_NEAR(translation_bound(C), 0.03 * std::sqrt(7.815), 1e-9);
  EXPECT_NEAR(rotation_bound(C), 0.002 * std::sqrt(7.815), 1e-9);
}

TEST(Bounds, OfWhatIsNoNumberAreNone) {
  Matrix6d C = 1e-6 * Matrix6d::Identity();
  C(0, 0) = C(3, 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(translation_bound(C)));
  EXPECT_TRUE(std::isnan(rotation_bound(C)));
}

TEST(LidarCovariances, AreWideAlongADirectionThatNoPlaneOfTheLidarFaces) {
  Random random(3);
  RigState truth;
  truth.T_G_base.emplace_back();
  for (int j = 1; j < stops; ++j) {
    truth.T_G_base.push_back(
        {exp_so3({0.0, 0.0, 0.7 * j}), Vector3d(0.1 * random.normal(), 0.1 * random.normal(), 0.0)});
  }
  truth.T_base_sensor = {SE3{}, SE3{exp_so3({0.0, 0.0, 0.4}), {0.1, 0.2, -0.1}}};
  std::vector<PlaneFeature> features = make_plane_features(truth, 600, 20, sigma_m, random);
  ParameterLayout layout(stops, 2);
  for (int j = 1; j < stops; ++j) layout.free_stop(j);
  layout.free_lidar(1);
  for (PlaneFeature& feature : features) {
    for (PlaneObservation& o : feature.observations) o.offset_variance = sigma_m * sigma_m / o.N;
  }
  const auto z_variance = [&] {
    const LidarCovariances c = lidar_covariances({features, truth, layout, {}});
    EXPECT_THAT(c.observable, testing::ElementsAre(1, 1));
    return c.with_priors[1](5, 5);
  };
  const double of_all = z_variance();
  for (PlaneFeature& feature : features) {
    if (std::abs(feature.normal_G.z()) < 0.05) continue;
    std::erase_if(feature.observations, [](const PlaneObservation& o) { return o.lidar == 1; });
  }
  // Some thirty walls are left to it, each tilted by less than three degrees.
  EXPECT_LT(of_all, 1e-6);
  EXPECT_GT(z_variance(), 1.0);
}

TEST(WeakTranslation, IsToldInTheFrameOfTheBase) {
  Matrix6d C = Matrix6d::Identity() * 1e-6;
  C(3, 3) = 1.0;  // along the sensor's own x
  const SE3 turned{exp_so3({0.0, 0.0, pi / 2.0}), Vector3d::Zero()};
  EXPECT_EQ(weak_translation_words(C, turned), "y (sideways) of the base frame");
  const SE3 aslant{exp_so3({0.0, 0.0, -pi / 4.0}), Vector3d::Zero()};
  EXPECT_EQ(weak_translation_words(C, aslant), "(0.71, -0.71, 0.00) of the base frame");
}

}  // namespace
}  // namespace rigcal
