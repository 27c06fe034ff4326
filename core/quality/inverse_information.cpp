#include "core/quality/inverse_information.h"

#include <Eigen/Eigenvalues>

namespace rigcal {

Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& H) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(scale.asDiagonal() * H * scale.asDiagonal());
  const Eigen::VectorXd values = solver.eigenvalues().cwiseMax(1e-12).cwiseInverse();
  const Eigen::MatrixXd inverse = solver.eigenvectors() * values.asDiagonal() * solver.eigenvectors().transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace rigcal
