#include "core/geometry/se3.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/geometry/numeric_derivative.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

Vector6d random_twist(Random& random, double rotation, double translation) {
  Vector6d xi;
  for (int i = 0; i < 6; ++i) xi[i] = random.normal() * (i < 3 ? rotation : translation);
  return xi;
}

TEST(SO3, LogUndoesExpFromZeroToNearPi) {
  Random random(1);
  for (const double angle : {0.0, 1e-9, 1e-5, 1e-2, 1.0, 3.0, 3.14159}) {
    const Vector3d axis = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const Vector3d phi = angle * axis;
    EXPECT_LT((log_so3(exp_so3(phi)) - phi).norm(), 1e-9) << "angle " << angle;
  }
}

TEST(SO3, LeftJacobianAgreesWithDifferences) {
  Random random(2);
  for (const double size : {1e-6, 0.3, 2.0}) {
    const Vector3d phi = size * Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const auto numeric = numeric_jacobian(
        [&](const Eigen::VectorXd& d) -> Eigen::VectorXd {
          return log_so3(exp_so3(phi + Vector3d(d)) * exp_so3(phi).transpose());
        },
        3);
    EXPECT_LT((numeric - left_jacobian_so3(phi)).norm(), 1e-9);
  }
}

TEST(SO3, TurnOntoTakesTheShortestWay) {
  Random random(5);
  for (int i = 0; i < 20; ++i) {
    const Vector3d from(random.normal(), random.normal(), random.normal());
    const Vector3d to(random.normal(), random.normal(), random.normal());
    const Matrix3d R = turn_onto(from, to);
    EXPECT_LT((R * from.normalized() - to.normalized()).norm(), 1e-12);
    EXPECT_NEAR(log_so3(R).dot(from), 0.0, 1e-9) << "a turn about the direction itself besides";
  }
  const Vector3d from(1.0, 2.0, 3.0);
  EXPECT_LT((turn_onto(from, from) - Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_LT((turn_onto(from, -from) * from + from).norm(), 1e-7);
}

TEST(SE3, LogUndoesExpAndInverseUndoesProduct) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const Vector6d xi = random_twist(random, 0.8, 3.0);
    const SE3 T = SE3::exp(xi);
    EXPECT_THAT(SE3::exp(T.log()), SE3Near(T, 1e-9, 1e-8));
    EXPECT_THAT(T * T.inverse(), SE3Near(SE3{}, 1e-9, 1e-8));
  }
}

TEST(SE3, AdjointMovesAPerturbationToTheLeft) {
  Random random(4);
  const SE3 T = SE3::exp(random_twist(random, 1.0, 2.0));
  const Vector6d xi = random_twist(random, 0.1, 0.1);
  EXPECT_THAT(T * SE3::exp(xi), SE3Near(SE3::exp(T.adjoint() * xi) * T, 1e-9, 1e-8));
}

TEST(SE3, QuaternionsInFilesAreXyzw) {
  const SE3 T = pose_deg(0, 0, 90, 0, 0, 0);
  const Eigen::Vector4d q = xyzw_from_rotation(T.R);
  EXPECT_NEAR(q[2], std::sqrt(0.5), 1e-12);
  EXPECT_NEAR(q[3], std::sqrt(0.5), 1e-12);
  EXPECT_LT((rotation_from_xyzw(2.0 * q) - T.R).norm(), 1e-12);
}

TEST(SE3, NearestRotationOfAScaledRotationIsTheRotation) {
  const SE3 T = pose_deg(10, 20, 30, 0, 0, 0);
  EXPECT_LT((nearest_rotation(1.01 * T.R) - T.R).norm(), 1e-12);
}

}  // namespace
}  // namespace rigcal
