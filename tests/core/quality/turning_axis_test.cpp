#include "core/quality/turning_axis.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

const Vector3d direction = Vector3d(0.05, -0.02, 1.0).normalized();
const Vector3d foot = Vector3d(0.2, -0.1, 0.3) - direction * direction.dot(Vector3d(0.2, -0.1, 0.3));

std::vector<SE3> turned(const std::vector<double>& degrees) {
  std::vector<SE3> poses;
  for (const double angle : degrees) poses.push_back(TurningAxis{direction, foot}.turn(to_rad(angle)));
  return poses;
}

TEST(TurningAxis, IsFoundFromTwoPosesAndFromMany) {
  for (const std::vector<double>& degrees : {std::vector<double>{0, 22}, {0, 90, 180, 270}, {0, -179, 3}}) {
    const auto axis = find_turning_axis(turned(degrees), std::vector<char>(degrees.size(), 1), Vector3d::UnitZ());
    ASSERT_TRUE(axis);
    EXPECT_LT((axis->direction - direction).norm(), 1e-9);
    EXPECT_LT((axis->point - foot).norm(), 1e-9);
  }
}

TEST(TurningAxis, LooksTheWayThatIsAskedFor) {
  const auto axis = find_turning_axis(turned({0, 40}), {1, 1}, -Vector3d::UnitZ());
  ASSERT_TRUE(axis);
  EXPECT_LT((axis->direction + direction).norm(), 1e-9);
  EXPECT_LT((axis->point - foot).norm(), 1e-9);
}

TEST(TurningAxis, LeavesUnknownPosesOut) {
  std::vector<SE3> poses = turned({0, 40, 80});
  poses[2] = SE3{exp_so3(Vector3d(1, 2, 3)), Vector3d(5, 5, 5)};
  const auto axis = find_turning_axis(poses, {1, 1, 0}, Vector3d::UnitZ());
  ASSERT_TRUE(axis);
  EXPECT_LT((axis->point - foot).norm(), 1e-9);
}

TEST(TurningAxis, IsNotMadeUpWhereNothingTurned) {
  EXPECT_FALSE(find_turning_axis(turned({0, 1}), {1, 1}, Vector3d::UnitZ()));
  EXPECT_FALSE(find_turning_axis(turned({0}), {1}, Vector3d::UnitZ()));
}

}  // namespace
}  // namespace rigcal
