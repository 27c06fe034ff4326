#pragma once

#include <Eigen/Core>
#include <vector>

namespace ceres {
struct CRSMatrix;
}

namespace rigcal {

/// Sigma of each unknown that boards share by how much it moves when one board after the other is left out (jackknife,
/// one step of Gauss-Newton each): what errs alike all over a board, of which its residuals know nothing, shows between
/// boards. `J` and `residuals` are those of a minimum, the shared unknowns in its first `shared` columns and then six
/// for each board; rows that touch no board are held by something else. Zeros for fewer than five boards.
[[nodiscard]] Eigen::VectorXd jackknife_sigmas(const ceres::CRSMatrix& J, const std::vector<double>& residuals,
                                               int shared);

}  // namespace rigcal
