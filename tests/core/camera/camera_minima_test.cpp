#include "core/camera/camera_minima.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

CameraState placed(double x_m, double turn_deg) {
  return CameraState{SE3{exp_so3(Vector3d(0.0, 0.0, to_rad(turn_deg))), {x_m, 0.0, 0.0}}};
}

Minimum at(double x_m, double turn_deg, double worth) {
  Minimum minimum;
  minimum.end.state = placed(x_m, turn_deg);
  minimum.worth = worth;
  return minimum;
}

TEST(CameraMinima, AreToldApartByPlaceOrByTurn) {
  const CameraState here = placed(1.0, 0.0);
  EXPECT_TRUE(is_same_minimum(here, here, 1.0));
  EXPECT_TRUE(is_same_minimum(here, placed(1.02, 0.1), 1.0));
  EXPECT_FALSE(is_same_minimum(here, placed(1.02, 0.1), 0.5));
  EXPECT_FALSE(is_same_minimum(here, placed(1.04, 0.0), 1.0));
  EXPECT_FALSE(is_same_minimum(here, placed(1.0, 0.3), 1.0));
}

TEST(CameraMinima, HaveForARunnerUpTheBestOfAnotherPlace) {
  std::vector<Minimum> found{at(3.0, 0.0, 0.2), at(1.01, 0.0, 0.7), at(2.0, 0.0, 0.4), at(1.0, 0.0, 0.8)};
  const Minima minima = compare_minima(found);
  EXPECT_EQ(minima.best.worth, 0.8);
  ASSERT_TRUE(minima.runner_up);
  EXPECT_EQ(minima.runner_up->t.x(), 2.0);
  EXPECT_DOUBLE_EQ(minima.runner_up_ratio, 0.5);
  EXPECT_EQ(found.front().worth, 0.8);
  EXPECT_EQ(found.back().worth, 0.2);
}

TEST(CameraMinima, OfOnePlaceHaveNoRunnerUp) {
  std::vector<Minimum> found{at(1.0, 0.0, 0.3), at(1.01, 0.05, 0.5)};
  const Minima minima = compare_minima(found);
  EXPECT_EQ(minima.best.worth, 0.5);
  EXPECT_FALSE(minima.runner_up);
  EXPECT_EQ(minima.runner_up_ratio, 0.0);
}

// Two that explain nothing are as good as each other.
TEST(CameraMinima, AreEquallyGoodWhereNothingIsExplained) {
  std::vector<Minimum> found{at(1.0, 0.0, 0.0), at(2.0, 0.0, 0.0)};
  const Minima minima = compare_minima(found);
  EXPECT_EQ(minima.best.end.state.T_base_camera.t.x(), 1.0);
  EXPECT_EQ(minima.runner_up_ratio, 1.0);
}

// A search around an end that was doubtful for another reason: nothing is clearly better, but one place is as good.
TEST(CameraMinima, WithAnEndThatIsNotBeatenHaveTheBestOtherForARunnerUp) {
  const Minimum end = at(1.0, 0.0, 20.0);
  std::vector<Minimum> found{at(2.0, 0.0, 17.6), at(1.01, 0.0, 23.0), at(3.0, 0.0, 21.0)};
  EXPECT_FALSE(is_beaten(end, found)) << "what explains more by a seventh is where the end is";
  const Minima minima = compare_with(end, found);
  EXPECT_EQ(minima.best.end.state.T_base_camera.t.x(), 1.0);
  ASSERT_TRUE(minima.runner_up);
  EXPECT_EQ(minima.runner_up->t.x(), 3.0);
  EXPECT_EQ(minima.runner_up_ratio, 1.0);
  std::vector<Minimum> nothing;
  EXPECT_FALSE(is_beaten(end, nothing));
  EXPECT_FALSE(compare_with(end, nothing).runner_up);
}

TEST(CameraMinima, BeatAnEndByATenthAndFromAnotherPlace) {
  const Minimum end = at(1.0, 0.0, 20.0);
  EXPECT_TRUE(is_beaten(end, {at(2.0, 0.0, 22.1)}));
  EXPECT_TRUE(is_beaten(end, {at(1.02, 0.0, 22.1)}));
  EXPECT_FALSE(is_beaten(end, {at(2.0, 0.0, 21.9)}));
}

}  // namespace
}  // namespace rigcal
