#pragma once

#include <Eigen/Core>
#include <optional>

namespace rigcal {

/// x of A x = b for a symmetric positive definite A, of which the lower triangle is read; nothing where it is not
/// positive definite. By Cholesky's decomposition: that of Eigen for few unknowns, for many in tiles on all threads.
/// The same bits for any number of threads.
[[nodiscard]] std::optional<Eigen::VectorXd> solve_positive(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace rigcal
