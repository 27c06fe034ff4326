#include "apps/experiment/targetless/motion_based.h"

#include <gtest/gtest.h>

#include <cmath>

namespace rigcal::targetless {
namespace {

const SE3 T_base_sensor{exp_so3({0.3, -0.8, 1.2}), {0.2, -0.1, 0.4}};

std::vector<SE3> drive() {
  std::vector<SE3> out;
  for (int k = 0; k < 8; ++k) {
    const double a = 0.6 * k;
    out.push_back(
        {exp_so3({0.2 * std::sin(a), 0.3 * std::cos(2.0 * a), a}), {std::cos(a), 2.0 * std::sin(a), 0.1 * k}});
  }
  return out;
}

TEST(HandEye, FindsWhatMovesAlike) {
  const std::vector<SE3> base = drive();
  const SE3 T_other_world{exp_so3({1.0, 0.5, -0.2}), {5.0, 3.0, -2.0}};
  std::vector<SE3> sensor;
  for (const SE3& T : base) sensor.push_back(T_other_world * T * T_base_sensor);
  const auto found = hand_eye(base, sensor);
  ASSERT_TRUE(found);
  EXPECT_LT((found->t - T_base_sensor.t).norm(), 1e-6);
  EXPECT_LT(rotation_distance(found->R, T_base_sensor.R), 1e-6);
}

// Level ground: turns about one axis leave only the height open.
TEST(HandEye, FindsAllButTheHeightOnLevelGround) {
  std::vector<SE3> base;
  for (int k = 0; k < 12; ++k) {
    const double a = 0.5 * k;
    base.push_back({exp_so3({0.0, 0.0, 2.0 * std::sin(a)}), {2.0 * std::cos(a), std::sin(2.0 * a), 0.0}});
  }
  std::vector<SE3> sensor;
  for (const SE3& T : base) sensor.push_back(T * T_base_sensor);
  const auto found = hand_eye(base, sensor);
  ASSERT_TRUE(found);
  EXPECT_LT(rotation_distance(found->R, T_base_sensor.R), 1e-6);
  EXPECT_LT((found->t - T_base_sensor.t).head<2>().norm(), 1e-6);
}

TEST(HandEye, NeedsThreePoses) {
  const std::vector<SE3> base = drive();
  EXPECT_FALSE(hand_eye({base[0], base[1]}, {base[0], base[1]}));
  EXPECT_FALSE(hand_eye(base, {base[0], base[1], base[2]}));
}

}  // namespace
}  // namespace rigcal::targetless
