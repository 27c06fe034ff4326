#include "core/geometry/point_cluster.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/base/random.h"
#include "core/geometry/symmetric_eigen.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

TEST(PointCluster, MovesAsItsPointsMove) {
  Random random(5);
  const SE3 T = pose_deg(30, -50, 70, 1.0, -2.0, 3.0);
  PointCluster cluster;
  PointCluster moved;
  PointCluster shifted;
  const Vector3d shift(0.5, -0.25, 8.0);
  for (int i = 0; i < 100; ++i) {
    const Vector3d p(random.normal(), random.normal(), random.normal());
    cluster.add(p);
    moved.add(T * p);
    shifted.add(p + shift);
  }
  EXPECT_LT((cluster.transformed(T).P - moved.P).norm(), 1e-10 * moved.P.norm());
  EXPECT_LT((cluster.transformed(T).v - moved.v).norm(), 1e-10 * moved.v.norm());
  EXPECT_LT((cluster.shifted(shift).P - shifted.P).norm(), 1e-10 * shifted.P.norm());
  EXPECT_LT((cluster.covariance() - cluster.shifted(shift).covariance()).norm(), 1e-10);
  EXPECT_LT((cluster.scaled(3.0).covariance() - cluster.covariance()).norm(), 1e-12);
}

TEST(SymmetricEigen, FastAndExactAgreeOnAThinPlane) {
  Random random(6);
  PointCluster cluster;
  const SE3 T = pose_deg(20, 40, 10, 5, 6, 7);
  for (int i = 0; i < 500; ++i) cluster.add(T * Vector3d(random.normal(), random.normal(), 0.01 * random.normal()));
  const SymmetricEigen exact = symmetric_eigen(cluster.covariance());
  const SymmetricEigen fast = symmetric_eigen_fast(cluster.covariance());
  EXPECT_NEAR(exact.values[0], 1e-4, 3e-5);
  EXPECT_LT((exact.values - fast.values).norm(), 1e-7);
  EXPECT_NEAR(std::abs(exact.vectors.col(0).dot(T.R.col(2))), 1.0, 1e-4);
}

}  // namespace
}  // namespace rigcal
