#include "core/geometry/symmetric_eigen.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"

namespace rigcal {
namespace {

TEST(SymmetricEigen, OfAnySizeAscendsAndTakesTheMatrixApart) {
  Random random(3);
  for (const Eigen::Index size : {1, 2, 3, 9}) {
    Eigen::MatrixXd A(size, size);
    for (double& value : A.reshaped()) value = random.normal();
    A = (A + A.transpose()).eval();
    const SymmetricEigenX eigen = symmetric_eigen_x(A);
    EXPECT_TRUE(std::is_sorted(eigen.values.begin(), eigen.values.end())) << size;
    EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Eigen::MatrixXd::Identity(size, size)).norm(), 1e-12);
    EXPECT_LT((A * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-12) << size;
    EXPECT_LT((symmetric_eigenvalues(A) - eigen.values).norm(), 1e-12) << size;
  }
}

}  // namespace
}  // namespace rigcal
