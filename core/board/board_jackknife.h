#pragma once

#include <Eigen/Core>
#include <vector>

namespace ceres {
struct CRSMatrix;
}

namespace rigcal {

/// Covariance of the unknowns that boards share by how they move when one board after the other is left out (jackknife,
/// one step of Gauss-Newton each): what errs alike all over a board, of which its residuals know nothing, shows between
/// boards. `J` and `residuals` are those of a minimum, the shared unknowns in its first `shared` columns and then six
/// for each board; rows that touch no board are held by something else. Zeros for fewer than `least_jackknife_boards`.
[[nodiscard]] Eigen::MatrixXd jackknife_covariance(const ceres::CRSMatrix& J, const std::vector<double>& residuals,
                                                   int shared);
constexpr int least_jackknife_boards = 5;

}  // namespace rigcal
