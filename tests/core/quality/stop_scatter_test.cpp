#include "core/quality/stop_scatter.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/quality/lidar_quality.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

constexpr int stops = 10;
constexpr int lidars = 3;
constexpr double sigma_m = 0.01;

// Three LiDARs that see planes all around at ten stops. The mount of the last stands elsewhere at each, by `wander_m`
// and `wander_rad` (1 sigma of each axis).
struct WanderingRig {
  RigState truth;
  RigState state;
  std::vector<PlaneFeature> features;
  ParameterLayout layout{stops, lidars};
  AdjustOptions options;

  WanderingRig(std::uint64_t seed, double wander_rad, double wander_m) {
    Random random(seed);
    truth.T_G_base.emplace_back();
    for (int j = 1; j < stops; ++j) truth.T_G_base.push_back(random_pose(random, 0.6, 0.2));
    truth.T_base_sensor = {SE3{}, random_pose(random, 0.8, 0.2), random_pose(random, 0.8, 0.2)};
    std::vector<SE3> wander;
    for (int j = 0; j < stops; ++j) wander.push_back(random_pose(random, wander_rad, wander_m));
    features = make_plane_features(truth, 30, 60, sigma_m, random);
    for (PlaneFeature& feature : features) {
      for (PlaneObservation& o : feature.observations) {
        o.offset_variance = sigma_m * sigma_m / o.N;
        const Vector3d n = truth.T_G_sensor(o.stop, o.lidar).R.transpose() * feature.normal_G;
        o.scatter -= o.N * sigma_m * sigma_m * n * n.transpose();
        if (o.lidar != 2) continue;
        // What the sensor sees of a fixed world from there.
        const SE3& moved = wander[static_cast<std::size_t>(o.stop)];
        o.mean = moved.inverse() * o.mean;
        o.scatter = moved.R.transpose() * o.scatter * moved.R;
      }
    }
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    for (int i = 1; i < lidars; ++i) layout.free_lidar(i);
    state = truth;
    adjust(features, layout, options, state);
  }
  [[nodiscard]] LidarCovariances covariances(std::optional<int> base = std::nullopt) const {
    return lidar_covariances({features, state, layout, options}, base);
  }
  // T_base_sensor exp(x), of the LiDAR against `base`.
  [[nodiscard]] Vector6d error(std::size_t lidar, std::size_t base) const {
    const SE3 is = state.T_base_sensor[base].inverse() * state.T_base_sensor[lidar];
    const SE3 should = truth.T_base_sensor[base].inverse() * truth.T_base_sensor[lidar];
    return (should.inverse() * is).log();
  }
};

double normalised(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(covariance.ldlt().solve(error)) / 6.0;
}

TEST(StopScatter, OfNoiseIsWhatTheCovarianceHasIt) {
  double mean = 0.0;
  int widened = 0;
  constexpr int runs = 30;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const WanderingRig rig(seed, 0.0, 0.0);
    const LidarCovariances c = rig.covariances();
    NormalEquations sum = build_normal_equations(rig.features, rig.state, rig.layout, HessianForm::gauss_newton);
    const StopMoves moves = stop_moves(rig.features, rig.state, rig.layout, sum.H.inverse(), std::nullopt);
    ASSERT_EQ(c.scatter.size(), static_cast<std::size_t>(lidars));
    EXPECT_TRUE(moves.moves[0].isZero());  // the base is fixed
    for (std::size_t i = 1; i < lidars; ++i) {
      widened += c.scatter[i].turn > 1.0 || c.scatter[i].place > 1.0 ? 1 : 0;
      EXPECT_GT(moves.stops[i], stops - 0.5);
      for (int j = 0; j < stops; ++j) mean += normalised(moves.moves[i].col(j), c.with_priors[i]) / (2 * runs);
    }
  }
  EXPECT_LE(widened, 3);
  // Of 1200 samples in six directions; planes that are fitted to the same stops take up a part.
  EXPECT_NEAR(mean, 0.9, 0.15);
}

// With sigmas by residuals alone squared errors are ten times as large and more.
TEST(StopScatter, HoldsTheErrorsWhereAMountWanders) {
  double by_base = 0.0;
  double by_itself = 0.0;
  double unwidened = 0.0;
  constexpr int runs = 40;
  for (std::uint64_t seed = 101; seed <= 100 + runs; ++seed) {
    const WanderingRig rig(seed, 0.003, 0.02);
    const LidarCovariances c = rig.covariances();
    EXPECT_GT(c.scatter[2].place, 4.0);
    EXPECT_GT(c.scatter[2].turn, 4.0);
    by_base += normalised(rig.error(2, 0), c.with_priors[2]) / runs;
    const StopScatter back{1.0 / c.scatter[2].turn, 1.0 / c.scatter[2].place};
    unwidened += normalised(rig.error(2, 0), widened(c.with_priors[2], back)) / runs;
    // Against the one that wanders all do, the one that was fixed too.
    const LidarCovariances against = rig.covariances(2);
    EXPECT_EQ(against.with_priors[2], Matrix6d::Zero());
    EXPECT_GT(against.scatter[0].place, 4.0);
    by_itself += normalised(rig.error(0, 2), against.with_priors[0]) / runs;
  }
  // The direction that scatters most stands for all three, so that it is below one.
  EXPECT_GT(unwidened, 10.0);
  EXPECT_LT(by_base, 1.5);
  EXPECT_GT(by_base, 0.2);
  EXPECT_LT(by_itself, 1.5);
  EXPECT_GT(by_itself, 0.2);
}

TEST(StopScatter, OfAFewStopsTellsNothing) {
  Eigen::Matrix<double, 6, Eigen::Dynamic> moves(6, 3);
  moves.setRandom();
  const StopScatter scatter = stop_scatter(moves, 3.0, 1e-6 * Matrix6d::Identity());
  EXPECT_EQ(scatter.turn, 1.0);
  EXPECT_EQ(scatter.place, 1.0);
}

}  // namespace
}  // namespace rigcal
