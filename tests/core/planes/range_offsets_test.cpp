#include "core/planes/range_offsets.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/planes/refine.h"
#include "core/voxel/range_correction.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

constexpr double prior_m = 0.015;

// A room seen by two LiDARs from eight stops of a full turn, each with its own error of the ranges.
struct BiasedRoom {
  RigState truth = turning_rig(8, Vector3d(0.25, 0.1, 0.0));
  std::vector<PatchCells> patches;
  std::vector<NoiseModel> noise{2, NoiseModel{0.01, 0.0, 0.0005}};
  ParameterLayout layout{8, 2};
  SE3 T_grid_G{exp_so3(Vector3d(0.3, 0.2, 0.5)), Vector3d(0.5, 0.7, 0.9)};

  BiasedRoom(std::uint64_t seed, const std::vector<double>& too_long_m) {
    Random random(seed);
    patches = make_patches(make_room(), truth, View{200.0, to_rad(40.0), noise[0]}, random);
    for (PatchCells& patch : patches) shorten_ranges(patch, -too_long_m[static_cast<std::size_t>(patch.lidar)]);
    for (int j = 1; j < 8; ++j) layout.free_stop(j);
    layout.free_lidar(1);
  }

  RefineSummary solve(RigState& state) const {
    SilentReporter reporter;
    return *refine({patches, noise, T_grid_G, {}, {}}, layout, standard_passes(3), RunContext{reporter}, state);
  }
};

TEST(RangeOffsets, AreToldFromWrongPlacesWithinTheirSigma) {
  double squares = 0.0;
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<double> too_long{0.006, -0.009};
    BiasedRoom room(seed, too_long);
    RigState state = room.truth;
    for (int round = 0; round < 3; ++round) {
      const RefineSummary solved = room.solve(state);
      const RangeOffsets found = find_range_offsets(solved.map.features, state, room.layout, {}, {}, prior_m);
      ASSERT_TRUE(found.known);
      if (round == 0) {
        // Without them the second LiDAR is some millimetres off.
        EXPECT_GT((state.T_base_sensor[1].t - room.truth.T_base_sensor[1].t).norm(), 0.004);
        for (int i = 0; i < 2; ++i) {
          const double sigma = std::sqrt(found.covariance(i, i));
          EXPECT_LT(sigma, 0.003);
          squares += std::pow((found.step_m[i] - too_long[static_cast<std::size_t>(i)]) / sigma, 2);
        }
      }
      for (PatchCells& patch : room.patches) shorten_ranges(patch, found.step_m[patch.lidar]);
      state = room.layout.moved(state, found.shift * found.step_m);
    }
    EXPECT_LT((state.T_base_sensor[1].t - room.truth.T_base_sensor[1].t).norm(), 0.002);
  }
  // Ten squares of unit variance; the first step leaves a little, as planes were gated at the wrong place.
  EXPECT_LT(squares / 10.0, 4.0);
}

TEST(RangeOffsets, ComeWithTheGradientAndTheCurvatureOfTheCost) {
  const BiasedRoom room(3, {0.0, 0.0});
  RigState state = room.truth;
  const RefineSummary solved = room.solve(state);
  const OffsetEquations equations = build_offset_equations(solved.map.features, state, room.layout);
  constexpr double step = 2e-4;
  // Clusters as they are with other ranges: p - b d, by their moments.
  const auto moved_cost = [&](double b) {
    std::vector<PlaneFeature> features = solved.map.features;
    for (PlaneFeature& feature : features) {
      for (std::size_t k = 0; k < feature.observations.size(); ++k) {
        PlaneObservation& o = feature.observations[k];
        const RayMoments& rays = feature.rays[k];
        if (o.lidar != 1) continue;
        o.mean -= b * rays.mean;
        o.scatter += b * b * rays.scatter - b * (rays.cross + rays.cross.transpose());
      }
    }
    return total_cost(features, state);
  };
  const double low = moved_cost(-step);
  const double middle = moved_cost(0.0);
  const double high = moved_cost(step);
  EXPECT_NEAR((high - low) / (2.0 * step), equations.g[1], 1e-3 * std::abs(equations.g[1]));
  // The Gauss-Newton form leaves out what noise adds to the curvature.
  EXPECT_NEAR((high - 2.0 * middle + low) / (step * step) / equations.H(1, 1), 1.0, 0.05);
}

TEST(RangeOffsets, AreAsWideAsUsualWhereNothingTellsThem) {
  BiasedRoom room(4, {0.0, 0.0});
  RigState state = room.truth;
  RefineSummary solved = room.solve(state);
  // One wall that both meet head on: a longer range and a place farther back are one and the same.
  PlaneFeature wall = solved.map.features.front();
  for (RayMoments& rays : wall.rays) {
    rays.cross.setZero();
    rays.scatter.setZero();
  }
  AdjustOptions options;
  options.stop_priors.assign(8, isotropic_prior(SE3{}, 1.0, 1.0));
  for (std::size_t j = 0; j < 8; ++j) options.stop_priors[j]->T = state.T_G_base[j];
  options.lidar_priors.assign(2, isotropic_prior(state.T_base_sensor[1], 1.0, 1.0));
  const RangeOffsets found = find_range_offsets({wall}, state, room.layout, options, {}, prior_m);
  ASSERT_TRUE(found.known);
  EXPECT_NEAR(std::sqrt(found.covariance(1, 1)), prior_m, 0.1 * prior_m);
  solved.map.features.front().rays.clear();
  EXPECT_FALSE(find_range_offsets(solved.map.features, state, room.layout, {}, {}, prior_m).known);
}

}  // namespace
}  // namespace rigcal
