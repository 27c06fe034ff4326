#include "core/geometry/symmetric_solve.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

TEST(SymmetricSolve, SolutionUndoesTheMatrix) {
  Random random(1);
  for (const Eigen::Index size : {1, 3, 9}) {
    Eigen::MatrixXd A(size, size);
    for (double& value : A.reshaped()) value = random.normal();
    A = (A * A.transpose() + 0.1 * Eigen::MatrixXd::Identity(size, size)).eval();
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(size, -1.0, 4.0);
    EXPECT_LT((solve_symmetric_x(A, A * x) - x).norm(), 1e-9) << size;
    if (size == 3) {
      EXPECT_LT((solve_symmetric3(A, A * x) - x).norm(), 1e-9);
    }
  }
}

}  // namespace
}  // namespace rigcal
