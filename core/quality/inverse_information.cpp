#include "core/quality/inverse_information.h"

#include <Eigen/Cholesky>

#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

// Of the smallest to the largest eigenvalue, roughly; far above where directions count as open.
constexpr double well_held = 1e-9;

}  // namespace

Eigen::MatrixXd inverse_information(const Eigen::MatrixXd& H) {
  const Eigen::VectorXd scale = H.diagonal().cwiseMax(1e-12).cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd scaled = scale.asDiagonal() * H * scale.asDiagonal();
  // Where nothing is near to open, which is as a rule, at a tenth of the cost.
  if (const Eigen::LLT<Eigen::MatrixXd> llt(scaled); llt.info() == Eigen::Success && llt.rcond() > well_held) {
    const Eigen::MatrixXd inverse = llt.solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
    return scale.asDiagonal() * (0.5 * (inverse + inverse.transpose())) * scale.asDiagonal();
  }
  const SymmetricEigenX eigen = symmetric_eigen_x(scaled);
  const Eigen::VectorXd values = eigen.values.cwiseMax(1e-12).cwiseInverse();
  const Eigen::MatrixXd inverse = eigen.vectors * values.asDiagonal() * eigen.vectors.transpose();
  return scale.asDiagonal() * inverse * scale.asDiagonal();
}

}  // namespace rigcal
