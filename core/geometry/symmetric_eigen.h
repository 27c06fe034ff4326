#pragma once

#include "core/geometry/se3.h"

namespace rigcal {

/// Eigenvalues in ascending order and the unit eigenvectors as columns of a rotation.
struct SymmetricEigen {
  Vector3d values;
  Matrix3d vectors;
};

/// The same of what is known of a pose; the eigenvectors are the columns of an orthogonal matrix.
struct SymmetricEigen6 {
  Vector6d values;
  Matrix6d vectors;
};

/// And of any number of unknowns.
struct SymmetricEigenX {
  Eigen::VectorXd values;
  Eigen::MatrixXd vectors;
};

/// Eigen decomposition of a symmetric matrix by QR iterations: every eigenvalue is good to rounding relative to the
/// largest, which the closed formula is not. NaN in, NaN out.
[[nodiscard]] SymmetricEigen symmetric_eigen(const Matrix3d& A);
[[nodiscard]] SymmetricEigen6 symmetric_eigen6(const Matrix6d& A);
[[nodiscard]] SymmetricEigenX symmetric_eigen_x(const Eigen::MatrixXd& A);
/// Without the eigenvectors, which are most of the work. A is not empty.
[[nodiscard]] Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A);

/// Closed formula, about five times quicker; the smallest eigenvalue is only good to 1e-8 of the largest. For tests of
/// shape, not for costs.
[[nodiscard]] SymmetricEigen symmetric_eigen_fast(const Matrix3d& A);

}  // namespace rigcal
