#include "core/planes/plane_factor.h"

#include <gtest/gtest.h>

#include "core/geometry/numeric_derivative.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/planes/normal_equations.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

struct Scenario {
  RigState state;
  std::vector<PlaneFeature> features;
  ParameterLayout layout{3, 2};
};

Scenario make_scenario(std::uint64_t seed, double disturbance) {
  Random random(seed);
  Scenario s;
  for (int j = 0; j < 3; ++j) s.state.T_G_base.push_back(random_pose(random, 0.5, 1.0));
  s.state.T_base_sensor = {SE3{}, random_pose(random, 1.0, 0.3)};
  s.features = make_plane_features(s.state, 4, 40, 0.02, random);
  s.state = disturbed(s.state, random, disturbance, disturbance);
  for (int j = 0; j < 3; ++j) s.layout.free_stop(j);
  s.layout.free_lidar(0);
  s.layout.free_lidar(1);
  return s;
}

TEST(PlaneFactor, CostIsTheSumOfSquaredDistancesToTheBestPlane) {
  Random random(1);
  RigState state{{SE3{}}, {SE3{}}};
  const auto features = make_plane_features(state, 1, 500, 0.02, random);
  // 500 points of sigma 1 after weighting, three degrees of freedom taken by the plane: 497 +- 5 sigma.
  EXPECT_NEAR(plane_cost(features[0], state), 497.0, 5.0 * std::sqrt(2.0 * 497.0));
}

class PlaneDerivativesAt : public ::testing::TestWithParam<double> {};

TEST_P(PlaneDerivativesAt, GradientAgreesWithDifferencesOfTheCost) {
  const Scenario s = make_scenario(2, GetParam());
  const NormalEquations analytic = build_normal_equations(s.features, s.state, s.layout, HessianForm::exact);
  const Eigen::MatrixXd numeric = numeric_jacobian(
      [&](const Eigen::VectorXd& dx) -> Eigen::VectorXd {
        return Eigen::VectorXd::Constant(1, total_cost(s.features, s.layout.moved(s.state, dx)));
      },
      s.layout.size());
  const double scale = analytic.H.diagonal().cwiseAbs().maxCoeff();
  // Differences of a cost c lose about eps c / h: relative to the curvature this is far below 1e-9.
  EXPECT_LT((numeric.row(0).transpose() - analytic.g).norm(), 1e-9 * scale);
}

TEST_P(PlaneDerivativesAt, ExactHessianAgreesWithDifferencesOfTheGradient) {
  const Scenario s = make_scenario(3, GetParam());
  const NormalEquations analytic = build_normal_equations(s.features, s.state, s.layout, HessianForm::exact);
  // d/dx of the gradient taken at T exp(x): the gradient there is with respect to a further right perturbation, which
  // differs from d/dx by the right Jacobian of exp; its part of first order is removed by averaging with the transpose.
  const Eigen::MatrixXd numeric = numeric_jacobian(
      [&](const Eigen::VectorXd& dx) -> Eigen::VectorXd {
        return build_normal_equations(s.features, s.layout.moved(s.state, dx), s.layout, HessianForm::exact).g;
      },
      s.layout.size());
  const Eigen::MatrixXd symmetric = 0.5 * (numeric + numeric.transpose());
  EXPECT_LT((symmetric - analytic.H).norm(), 1e-8 * analytic.H.norm());
}

TEST_P(PlaneDerivativesAt, CommonRigidMotionOfAllPosesLeavesCostAndGradientAlone) {
  const Scenario s = make_scenario(4, GetParam());
  const NormalEquations sum = build_normal_equations(s.features, s.state, s.layout, HessianForm::exact);
  // A motion K of the world moves every base pose: G' = exp(k) G = G exp(Ad(G^-1) k).
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(s.layout.size(), 6);
  for (int j = 0; j < s.layout.stops(); ++j)
    K.middleRows<6>(s.layout.stop_index(j)) = s.state.T_G_base[static_cast<std::size_t>(j)].inverse().adjoint();
  const double scale = sum.H.norm();
  EXPECT_LT((sum.g.transpose() * K).norm(), 1e-10 * scale);
  EXPECT_LT((K.transpose() * sum.H * K).norm(), 1e-9 * scale * K.squaredNorm());
}

INSTANTIATE_TEST_SUITE_P(NearAndFar, PlaneDerivativesAt, ::testing::Values(0.0, 0.01, 0.1));

TEST(PlaneFactor, GaussNewtonHessianIsPositiveSemidefiniteAndExactWhereThereIsNoNoise) {
  Random random(5);
  RigState state;
  for (int j = 0; j < 3; ++j) state.T_G_base.push_back(random_pose(random, 0.5, 1.0));
  state.T_base_sensor = {SE3{}, random_pose(random, 1.0, 0.3)};
  const auto features = make_plane_features(state, 5, 30, 0.0, random);
  ParameterLayout layout(3, 2);
  for (int j = 1; j < 3; ++j) layout.free_stop(j);
  layout.free_lidar(1);
  const auto exact = build_normal_equations(features, state, layout, HessianForm::exact);
  const auto gauss_newton = build_normal_equations(features, state, layout, HessianForm::gauss_newton);
  EXPECT_LT((exact.H - gauss_newton.H).norm(), 1e-9 * exact.H.norm());
  const RigState far = disturbed(state, random, 0.1, 0.2);
  const auto there = build_normal_equations(features, far, layout, HessianForm::gauss_newton);
  const Eigen::VectorXd values = symmetric_eigenvalues(there.H);
  EXPECT_GT(values.minCoeff(), -1e-9 * values.maxCoeff());
}

}  // namespace
}  // namespace rigcal
