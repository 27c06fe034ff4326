#pragma once

#include "core/geometry/se3.h"

/// As matrix6.h does it for a pose: what the compiler takes seconds for, once.
namespace rigcal {

/// A^-1 b of a symmetric A that has an inverse, by LDLT. NaN in, NaN out.
[[nodiscard]] Vector3d solve_symmetric3(const Matrix3d& A, const Vector3d& b);
[[nodiscard]] Eigen::VectorXd solve_symmetric_x(const Eigen::MatrixXd& A, const Eigen::VectorXd& b);

}  // namespace rigcal
