#pragma once

#include "core/geometry/se3.h"

/// What many do with the information and the covariance of a pose. The compiler takes seconds for each of these, so it
/// does them once.
namespace rigcal {

/// A^-1 b of a symmetric A that has an inverse, by LDLT. NaN in, NaN out.
[[nodiscard]] Vector6d solve_symmetric6(const Matrix6d& A, const Vector6d& b);

/// A^-1 of such an A, by LDLT.
[[nodiscard]] Matrix6d inverse_symmetric6(const Matrix6d& A);

/// A^-1 by LU; not finite where there is none.
[[nodiscard]] Matrix6d inverse6(const Matrix6d& A);

}  // namespace rigcal
