#include "core/geometry/matrix6.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>

namespace rigcal {

Vector6d solve_symmetric6(const Matrix6d& A, const Vector6d& b) { return A.ldlt().solve(b); }

Matrix6d inverse_symmetric6(const Matrix6d& A) { return A.ldlt().solve(Matrix6d::Identity()); }

Matrix6d inverse6(const Matrix6d& A) { return A.inverse(); }

}  // namespace rigcal
