#include "core/geometry/matrix6.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

Matrix6d random_information(Random& random) {
  Matrix6d A;
  for (double& value : A.reshaped()) value = random.normal();
  return A * A.transpose() + 0.1 * Matrix6d::Identity();
}

TEST(Matrix6, SolutionAndInverseUndoTheMatrix) {
  Random random(1);
  for (int k = 0; k < 20; ++k) {
    const Matrix6d A = random_information(random);
    const Vector6d x = Vector6d::LinSpaced(-1.0, 4.0);
    EXPECT_LT((solve_symmetric6(A, A * x) - x).norm(), 1e-9);
    EXPECT_LT((inverse_symmetric6(A) * A - Matrix6d::Identity()).norm(), 1e-9);
    EXPECT_LT((inverse6(A) * A - Matrix6d::Identity()).norm(), 1e-9);
  }
}

TEST(Matrix6, EigenvaluesAscendAndTheirVectorsAreUnitColumns) {
  Random random(2);
  for (int k = 0; k < 20; ++k) {
    const Matrix6d A = random_information(random);
    const SymmetricEigen6 eigen = symmetric_eigen6(A);
    EXPECT_TRUE(std::is_sorted(eigen.values.begin(), eigen.values.end()));
    EXPECT_LT((eigen.vectors.transpose() * eigen.vectors - Matrix6d::Identity()).norm(), 1e-12);
    EXPECT_LT((A * eigen.vectors - eigen.vectors * eigen.values.asDiagonal()).norm(), 1e-11);
  }
}

}  // namespace
}  // namespace rigcal
