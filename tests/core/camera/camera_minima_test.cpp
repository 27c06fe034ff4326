#include "core/camera/camera_minima.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

EdgeSolution at(double x_m, double turn_deg, double score) {
  EdgeSolution solution;
  solution.state.T_base_camera = {exp_so3(Vector3d(0.0, 0.0, to_rad(turn_deg))), {x_m, 0.0, 0.0}};
  solution.score = score;
  return solution;
}

TEST(CameraMinima, AreToldApartByPlaceOrByTurn) {
  const CameraState here = at(1.0, 0.0, 0.0).state;
  EXPECT_TRUE(is_same_minimum(here, here, 1.0));
  EXPECT_TRUE(is_same_minimum(here, at(1.02, 0.1, 0.0).state, 1.0));
  EXPECT_FALSE(is_same_minimum(here, at(1.02, 0.1, 0.0).state, 0.5));
  EXPECT_FALSE(is_same_minimum(here, at(1.04, 0.0, 0.0).state, 1.0));
  EXPECT_FALSE(is_same_minimum(here, at(1.0, 0.3, 0.0).state, 1.0));
}

TEST(CameraMinima, HaveForARunnerUpTheBestOfAnotherPlace) {
  std::vector<EdgeSolution> solutions{at(3.0, 0.0, 0.2), at(1.01, 0.0, 0.7), at(2.0, 0.0, 0.4), at(1.0, 0.0, 0.8)};
  const Minima minima = compare_minima(solutions);
  EXPECT_EQ(minima.best.score, 0.8);
  ASSERT_TRUE(minima.runner_up);
  EXPECT_EQ(minima.runner_up->t.x(), 2.0);
  EXPECT_DOUBLE_EQ(minima.runner_up_ratio, 0.5);
  EXPECT_EQ(solutions.front().score, 0.8);
  EXPECT_EQ(solutions.back().score, 0.2);
}

TEST(CameraMinima, OfOnePlaceHaveNoRunnerUp) {
  std::vector<EdgeSolution> solutions{at(1.0, 0.0, 0.3), at(1.01, 0.05, 0.5)};
  const Minima minima = compare_minima(solutions);
  EXPECT_EQ(minima.best.score, 0.5);
  EXPECT_FALSE(minima.runner_up);
  EXPECT_EQ(minima.runner_up_ratio, 0.0);
}

// Two that explain nothing are as good as each other.
TEST(CameraMinima, AreEquallyGoodWhereNothingIsExplained) {
  std::vector<EdgeSolution> solutions{at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0)};
  const Minima minima = compare_minima(solutions);
  EXPECT_EQ(minima.best.state.T_base_camera.t.x(), 1.0);
  EXPECT_EQ(minima.runner_up_ratio, 1.0);
}

}  // namespace
}  // namespace rigcal
