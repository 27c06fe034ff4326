#include "core/planes/adjust.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/geometry/symmetric_solve.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

struct Problem {
  RigState truth;
  std::vector<PlaneFeature> features;
  ParameterLayout layout{4, 3};
};

Problem make_problem(std::uint64_t seed, double sigma) {
  Random random(seed);
  Problem p;
  p.truth.T_G_base = {SE3{}};
  for (int j = 1; j < 4; ++j) p.truth.T_G_base.push_back(random_pose(random, 0.5, 1.0));
  p.truth.T_base_sensor = {SE3{}, random_pose(random, 1.0, 0.3), random_pose(random, 1.0, 0.3)};
  p.features = make_plane_features(p.truth, 12, 50, sigma, random);
  for (int j = 1; j < 4; ++j) p.layout.free_stop(j);
  for (int i = 1; i < 3; ++i) p.layout.free_lidar(i);
  return p;
}

class AdjustWith : public ::testing::TestWithParam<HessianForm> {};

TEST_P(AdjustWith, FindsTheTruthFromFiveDegreesWithoutNoise) {
  const Problem p = make_problem(1, 0.0);
  Random random(2);
  RigState state = disturbed(p.truth, random, 0.05, 0.1);
  AdjustOptions options;
  options.form = GetParam();
  options.max_iterations = 50;
  const AdjustSummary summary = adjust(p.features, p.layout, options, state);
  EXPECT_TRUE(summary.converged);
  for (std::size_t j = 0; j < 4; ++j) EXPECT_THAT(state.T_G_base[j], SE3Near(p.truth.T_G_base[j], 1e-5, 1e-3));
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_THAT(state.T_base_sensor[i], SE3Near(p.truth.T_base_sensor[i], 1e-5, 1e-3));
}

INSTANTIATE_TEST_SUITE_P(BothForms, AdjustWith, ::testing::Values(HessianForm::exact, HessianForm::gauss_newton));

TEST(Adjust, ErrorsScatterAsTheInverseHessianSays) {
  // NEES of the twelve free extrinsic parameters over 60 draws: mean 12, its standard error sqrt(24 / 60) = 0.63.
  double nees = 0.0;
  constexpr int draws = 60;
  for (int draw = 0; draw < draws; ++draw) {
    const Problem p = make_problem(100 + static_cast<std::uint64_t>(draw), 0.02);
    RigState state = p.truth;
    const AdjustSummary summary = adjust(p.features, p.layout, AdjustOptions{}, state);
    ASSERT_TRUE(summary.converged);
    const auto sum = build_normal_equations(p.features, state, p.layout, HessianForm::gauss_newton);
    const Eigen::MatrixXd covariance = 2.0 * sum.H.inverse();
    Eigen::VectorXd e(12);
    for (std::size_t i = 1; i < 3; ++i)
      e.segment<6>(6 * (static_cast<long>(i) - 1)) =
          (p.truth.T_base_sensor[i].inverse() * state.T_base_sensor[i]).log();
    nees += e.dot(solve_symmetric_x(covariance.bottomRightCorner<12, 12>(), e));
  }
  EXPECT_NEAR(nees / draws, 12.0, 4.0 * 0.63);
}

// The last step, which rounding refuses or does not, takes nothing off: else it would seem to be stopped too early.
TEST(Adjust, TellsOfTheStepThatIsItsLast) {
  for (std::uint64_t seed = 100; seed < 120; ++seed) {
    const Problem p = make_problem(seed, 0.02);
    RigState state = p.truth;
    (void)adjust(p.features, p.layout, AdjustOptions{}, state);
    const AdjustSummary again = adjust(p.features, p.layout, AdjustOptions{}, state);
    EXPECT_TRUE(again.converged);
    EXPECT_EQ(again.iterations, 1) << seed;
    ASSERT_EQ(again.costs.size(), 2U) << seed;
    EXPECT_NEAR(again.costs[0], again.costs[1], 1e-6);
  }
}

TEST(Adjust, LeavesFixedBlocksUntouchedAndStaysNearThePriorWhereNothingIsSeen) {
  Problem p = make_problem(3, 0.02);
  for (PlaneFeature& f : p.features)
    std::erase_if(f.observations, [](const PlaneObservation& o) { return o.stop == 3; });
  RigState state = p.truth;
  Random random(4);
  state = disturbed(state, random, 0.01, 0.01);
  const SE3 unseen = state.T_G_base[3];
  AdjustOptions options;
  options.stop_priors.assign(4, isotropic_prior(unseen, 0.03, 0.05));
  options.stop_priors[1].reset();
  options.stop_priors[2].reset();
  options.max_iterations = 30;
  EXPECT_TRUE(adjust(p.features, p.layout, options, state).converged);
  EXPECT_EQ(state.T_G_base[0].t, p.truth.T_G_base[0].t);
  EXPECT_EQ(state.T_base_sensor[0].R, p.truth.T_base_sensor[0].R);
  EXPECT_THAT(state.T_G_base[3], SE3Near(unseen, 1e-9, 1e-6));
}

// It took part, but lies on no plane: the others are solved as without it.
TEST(Adjust, ALidarOnNoPlaneStaysAndDoesNotStopTheOthers) {
  for (const HessianForm form : {HessianForm::exact, HessianForm::gauss_newton}) {
    Problem p = make_problem(5, 0.0);
    for (PlaneFeature& f : p.features)
      std::erase_if(f.observations, [](const PlaneObservation& o) { return o.lidar == 2; });
    Random random(6);
    RigState state = disturbed(p.truth, random, 0.02, 0.05);
    const SE3 unseen = state.T_base_sensor[2];
    AdjustOptions options;
    options.form = form;
    options.max_iterations = 50;
    EXPECT_TRUE(adjust(p.features, p.layout, options, state).converged);
    EXPECT_THAT(state.T_base_sensor[1], SE3Near(p.truth.T_base_sensor[1], 1e-5, 1e-3));
    EXPECT_EQ(state.T_base_sensor[2].t, unseen.t);
  }
}

}  // namespace
}  // namespace rigcal
