#include "core/quality/stop_scatter.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/geometry/matrix6.h"
#include "core/quality/lidar_quality.h"
#include "tests/core/quality/loose_rig.h"

namespace rigcal {
namespace {

constexpr int stops = 10;
constexpr int lidars = LooseRig::lidars;

// The mount of the last LiDAR stands elsewhere at each stop, by these (1 sigma of each axis).
LooseRig wandering(std::uint64_t seed, double wander_rad, double wander_m) {
  Random of_mount(seed, 1);
  std::vector<SE3> mount;
  for (int j = 0; j < stops; ++j) mount.push_back(random_pose(of_mount, wander_rad, wander_m));
  Random random(seed);
  return {stops, 30, random, [&](int stop) { return mount[static_cast<std::size_t>(stop)]; }};
}

LidarCovariances covariances_of(const LooseRig& rig, std::optional<int> base = std::nullopt) {
  return lidar_covariances({rig.features, rig.state, rig.layout, rig.options}, base);
}

// x in T_base_sensor exp(x), of a LiDAR against `base`.
Vector6d error_of(const LooseRig& rig, std::size_t lidar, std::size_t base) {
  const SE3 is = rig.state.T_base_sensor[base].inverse() * rig.state.T_base_sensor[lidar];
  const SE3 should = rig.truth.T_base_sensor[base].inverse() * rig.truth.T_base_sensor[lidar];
  return (should.inverse() * is).log();
}

double normalised(const Vector6d& error, const Matrix6d& covariance) {
  return error.dot(solve_symmetric6(covariance, error)) / 6.0;
}

TEST(StopScatter, OfNoiseIsWhatTheCovarianceHasIt) {
  double mean = 0.0;
  int widened = 0;
  constexpr int runs = 30;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const LooseRig rig = wandering(seed, 0.0, 0.0);
    const LidarCovariances c = covariances_of(rig);
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
    const LooseRig rig = wandering(seed, 0.003, 0.02);
    const LidarCovariances c = covariances_of(rig);
    EXPECT_GT(c.scatter[2].place, 4.0);
    EXPECT_GT(c.scatter[2].turn, 4.0);
    by_base += normalised(error_of(rig, 2, 0), c.with_priors[2]) / runs;
    const StopScatter back{1.0 / c.scatter[2].turn, 1.0 / c.scatter[2].place};
    unwidened += normalised(error_of(rig, 2, 0), widened(c.with_priors[2], back)) / runs;
    // Against the one that wanders all do, the one that was fixed too.
    const LidarCovariances against = covariances_of(rig, 2);
    EXPECT_EQ(against.with_priors[2], Matrix6d::Zero());
    EXPECT_GT(against.scatter[0].place, 4.0);
    by_itself += normalised(error_of(rig, 0, 2), against.with_priors[0]) / runs;
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
