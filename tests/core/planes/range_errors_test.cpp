#include "core/planes/range_errors.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/planes/refine.h"
#include "core/voxel/range_correction.h"
#include "tests/support/biased_room.h"

namespace rigcal {
namespace {

constexpr RangePrior prior{0.015, 0.010, 0.001};

struct TakenOut {
  RangeLaw law = RangeLaw::none;
  double squares = 0.0;  // Of what the first round found over its sigma, the sum of both LiDARs.
  double error_before_m = 0.0;
  double error_after_m = 0.0;
};

// In three rounds as calibrations do, by the likeliest law of the first one.
TakenOut take_out(const std::vector<RangeError>& too_long, std::uint64_t seed) {
  BiasedRoom room(seed, too_long);
  RigState state = room.truth;
  TakenOut out;
  std::vector<RangeError> taken_out(2);
  for (int round = 0; round < 3; ++round) {
    const RefineSummary solved = room.solve(state);
    if (round == 0) out.error_before_m = room.error_of(state);
    const RangeErrors found = find_range_errors(solved.map.features, state, room.layout, {}, taken_out, prior);
    EXPECT_TRUE(found.known);
    for (const RangeLaw each : all_range_laws) {
      if (round == 0 && found.fit(each).likely > found.fit(out.law).likely) out.law = each;
    }
    const RangeFit& fit = found.fit(out.law);
    for (int i = 0; i < 2; ++i) {
      const auto at = static_cast<std::size_t>(i);
      const double darkness = found.darkness[at];
      taken_out[at] += fit.step_of(i);
      if (round > 0) continue;
      const double variance = fit.variance_at(i, darkness);
      EXPECT_LT(variance, 0.003 * 0.003);
      out.squares += std::pow(fit.step_of(i).at(darkness) - too_long[at].at(darkness), 2) / variance;
    }
    for (PatchCells& patch : room.patches) shorten_ranges(patch, fit.step_of(patch.lidar));
    state = room.layout.moved(state, found.shift * fit.step_m);
  }
  for (std::size_t i = 0; i < 2; ++i) EXPECT_NEAR(taken_out[i].at(0.65), too_long[i].at(0.65), 0.003);
  out.error_after_m = room.error_of(state);
  return out;
}

TEST(RangeErrors, AreToldFromWrongPlacesWithinTheirSigma) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TakenOut out = take_out({{0.006, 0.0}, {-0.009, 0.0}}, seed);
    EXPECT_EQ(out.law, RangeLaw::constant);
    EXPECT_GT(out.error_before_m, 0.004);
    EXPECT_LT(out.error_after_m, 0.002);
    squares += out.squares;
  }
  // Ten squares of unit variance; the first step leaves a little, as planes were gated at the wrong place.
  EXPECT_LT(squares / 10.0, 4.0);
}

// Alike in both LiDARs, they move neither by much in so small a room.
TEST(RangeErrors, OfDarkSurfacesAreFound) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const TakenOut out = take_out({{0.0, 0.015}, {0.0, 0.015}}, seed);
    EXPECT_EQ(out.law, RangeLaw::by_darkness);
    EXPECT_LT(out.error_after_m, 0.0015);
    squares += out.squares;
  }
  EXPECT_LT(squares / 10.0, 4.0);
}

// Where each unit has a constant of its own besides.
TEST(RangeErrors, OfBothKindsAreToldApartWithinTheirSigma) {
  const std::vector<RangeError> too_long{{0.006, 0.012}, {-0.012, 0.012}};
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const BiasedRoom room(seed, too_long);
    RigState state = room.truth;
    const RefineSummary solved = room.solve(state);
    const RangeErrors found = find_range_errors(solved.map.features, state, room.layout, {}, {}, prior);
    ASSERT_TRUE(found.known);
    EXPECT_LT(found.fit(RangeLaw::none).likely + found.fit(RangeLaw::by_darkness).likely, 0.01);
    const RangeFit& fit = found.fit(RangeLaw::both);
    for (int i = 0; i < 2; ++i) {
      const auto at = static_cast<std::size_t>(i);
      for (const double darkness : {0.0, 1.0}) {
        const double error = fit.step_of(i).at(darkness) - too_long[at].at(darkness);
        squares += std::pow(error, 2) / fit.variance_at(i, darkness);
      }
    }
  }
  EXPECT_LT(squares / 20.0, 3.0);
}

TEST(RangeErrors, AreNoneWhereThereAreNone) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const BiasedRoom room(seed, {{}, {}});
    RigState state = room.truth;
    const RefineSummary solved = room.solve(state);
    const RangeErrors found = find_range_errors(solved.map.features, state, room.layout, {}, {}, prior);
    ASSERT_TRUE(found.known);
    EXPECT_GT(found.fit(RangeLaw::none).likely, 0.5) << seed;
    EXPECT_NEAR(found.likely_covering(RangeLaw::none), 1.0, 1e-9);
  }
}

TEST(RangeErrors, ComeWithTheGradientAndTheCurvatureOfTheCost) {
  const BiasedRoom room(3, {{}, {}});
  RigState state = room.truth;
  const RefineSummary solved = room.solve(state);
  const RangeEquations equations = build_range_equations(solved.map.features, state, room.layout);
  constexpr double step = 2e-4;
  // Clusters as they are with other ranges: p - (b + c s) d with the darkness s of the whole plane, by their moments.
  const auto moved_cost = [&](double b, double c) {
    std::vector<PlaneFeature> features = solved.map.features;
    for (PlaneFeature& feature : features) {
      double darkness = 0.0;
      double weight = 0.0;
      for (std::size_t k = 0; k < feature.observations.size(); ++k) {
        const double w = feature.observations[k].weight * feature.observations[k].N;
        darkness += w * feature.rays[k].darkness;
        weight += w;
      }
      const double moved = b + c * darkness / weight;
      for (std::size_t k = 0; k < feature.observations.size(); ++k) {
        PlaneObservation& o = feature.observations[k];
        const RayMoments& rays = feature.rays[k];
        if (o.lidar != 1) continue;
        o.mean -= moved * rays.mean;
        o.scatter += moved * moved * rays.scatter - moved * (rays.cross + rays.cross.transpose());
      }
    }
    return total_cost(features, state);
  };
  const double middle = moved_cost(0.0, 0.0);
  const auto expect_slope_and_curvature = [&](double b, double c, const Eigen::Vector4d& direction) {
    const double low = moved_cost(-step * b, -step * c);
    const double high = moved_cost(step * b, step * c);
    const double g = direction.dot(equations.g);
    EXPECT_NEAR((high - low) / (2.0 * step), g, 1e-3 * std::abs(g));
    // The Gauss-Newton form leaves out what noise adds to the curvature.
    const double H = direction.dot(equations.H * direction);
    EXPECT_NEAR((high - 2.0 * middle + low) / (step * step) / H, 1.0, 0.05);
  };
  expect_slope_and_curvature(1.0, 0.0, Eigen::Vector4d(0.0, 1.0, 0.0, 0.0));
  expect_slope_and_curvature(0.0, 1.0, Eigen::Vector4d(0.0, 0.0, 0.0, 1.0));
  expect_slope_and_curvature(1.0, -1.0, Eigen::Vector4d(0.0, 1.0, 0.0, -1.0));
}

TEST(RangeErrors, AreAsWideAsUsualWhereNothingTellsThem) {
  BiasedRoom room(4, {{}, {}});
  RigState state = room.truth;
  RefineSummary solved = room.solve(state);
  // One grey wall that both meet head on: a longer range and a place farther back are one and the same.
  PlaneFeature wall = solved.map.features.front();
  for (RayMoments& rays : wall.rays) {
    rays.darkness = 0.5;
    rays.cross.setZero();
    rays.scatter.setZero();
  }
  AdjustOptions options;
  options.stop_priors.assign(8, isotropic_prior(SE3{}, 1.0, 1.0));
  for (std::size_t j = 0; j < 8; ++j) options.stop_priors[j]->T = state.T_G_base[j];
  options.lidar_priors.assign(2, isotropic_prior(state.T_base_sensor[1], 1.0, 1.0));
  const RangeErrors found = find_range_errors({wall}, state, room.layout, options, {}, prior);
  ASSERT_TRUE(found.known);
  const RangeFit& constant = found.fit(RangeLaw::constant);
  EXPECT_NEAR(std::sqrt(constant.covariance(1, 1)), prior.mean_m, 0.1 * prior.mean_m);
  const RangeFit& both = found.fit(RangeLaw::both);
  EXPECT_NEAR(std::sqrt(both.covariance(3, 3)), prior.black_m, 0.1 * prior.black_m);
  for (const RangeFit& fit : found.fits) EXPECT_NEAR(fit.likely, 0.25, 0.1);
  // A LiDAR on no plane keeps nobody from being told.
  ParameterLayout with_one_more(8, 3);
  for (int j = 1; j < 8; ++j) with_one_more.free_stop(j);
  for (int i = 1; i < 3; ++i) with_one_more.free_lidar(i);
  RigState of_three = state;
  of_three.T_base_sensor.emplace_back();
  const RangeErrors beside = find_range_errors(solved.map.features, of_three, with_one_more, {}, {}, prior);
  const RangeErrors alone = find_range_errors(solved.map.features, state, room.layout, {}, {}, prior);
  ASSERT_TRUE(beside.known);
  for (int i = 0; i < 2; ++i) {
    EXPECT_NEAR(beside.fit(RangeLaw::constant).step_m[i], alone.fit(RangeLaw::constant).step_m[i], 1e-9);
  }
  solved.map.features.front().rays.clear();
  EXPECT_FALSE(find_range_errors(solved.map.features, state, room.layout, {}, {}, prior).known);
}

}  // namespace
}  // namespace rigcal
