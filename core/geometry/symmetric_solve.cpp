#include "core/geometry/symmetric_solve.h"

#include <Eigen/Cholesky>

namespace rigcal {

Vector3d solve_symmetric3(const Matrix3d& A, const Vector3d& b) { return A.ldlt().solve(b); }

Eigen::VectorXd solve_symmetric_x(const Eigen::MatrixXd& A, const Eigen::VectorXd& b) { return A.ldlt().solve(b); }

}  // namespace rigcal
