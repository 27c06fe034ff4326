#include "core/planes/positive_solver.h"

#include <gtest/gtest.h>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

// Of the kind B B^T + few.
Eigen::MatrixXd positive(Eigen::Index n) {
  Random random(static_cast<std::uint64_t>(n));
  Eigen::MatrixXd B(n, n);
  for (Eigen::Index i = 0; i < B.size(); ++i) B.data()[i] = random.normal();
  return B * B.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n);
}

TEST(SolvePositive, SolvesForFewAndForMany) {
  for (const Eigen::Index n : {1, 6, 255, 256, 300, 449}) {
    const Eigen::MatrixXd A = positive(n);
    const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n, -1.0, 2.0);
    const auto found = solve_positive(A, A * x);
    ASSERT_TRUE(found) << n;
    EXPECT_LT((*found - x).norm(), 1e-6 * x.norm()) << n;
  }
}

TEST(SolvePositive, ReadsTheLowerTriangleOnly) {
  const Eigen::MatrixXd A = positive(320);
  const Eigen::VectorXd b = Eigen::VectorXd::Ones(320);
  Eigen::MatrixXd lower = A;
  lower.triangularView<Eigen::StrictlyUpper>().setConstant(7.0);
  EXPECT_TRUE(*solve_positive(A, b) == *solve_positive(lower, b));
}

TEST(SolvePositive, RefusesWhatIsNotPositiveDefinite) {
  for (const Eigen::Index n : {12, 400}) {
    Eigen::MatrixXd A = positive(n);
    A(n - 1, n - 1) = -1.0;
    EXPECT_FALSE(solve_positive(A, Eigen::VectorXd::Ones(n)));
  }
}

TEST(SolvePositive, GivesTheSameBitsWithAnyNumberOfThreads) {
  const Eigen::MatrixXd A = positive(500);
  const Eigen::VectorXd b = Eigen::VectorXd::LinSpaced(500, 0.0, 1.0);
  const int threads = thread_count();
  set_thread_count(1);
  const Eigen::VectorXd one = *solve_positive(A, b);
  set_thread_count(3);
  EXPECT_TRUE(*solve_positive(A, b) == one);
  set_thread_count(threads);
}

}  // namespace
}  // namespace rigcal
