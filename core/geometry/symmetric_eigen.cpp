#include "core/geometry/symmetric_eigen.h"

#include <Eigen/Eigenvalues>

namespace rigcal {

SymmetricEigen symmetric_eigen(const Matrix3d& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix3d> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigen6 symmetric_eigen6(const Matrix6d& A) {
  const Eigen::SelfAdjointEigenSolver<Matrix6d> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

SymmetricEigenX symmetric_eigen_x(const Eigen::MatrixXd& A) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

Eigen::VectorXd symmetric_eigenvalues(const Eigen::MatrixXd& A) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(A, Eigen::EigenvaluesOnly).eigenvalues();
}

SymmetricEigen symmetric_eigen_fast(const Matrix3d& A) {
  Eigen::SelfAdjointEigenSolver<Matrix3d> solver;
  solver.computeDirect(A);
  return {solver.eigenvalues(), solver.eigenvectors()};
}

}  // namespace rigcal
