#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/planes/normal_equations.h"

namespace rigcal {

/// By how many times the variance that a covariance has what single stops say of a LiDAR's extrinsics scatters about
/// what all of them say. 1 where chance explains it.
struct StopScatter {
  double turn = 1.0;
  double place = 1.0;
};

/// How the LiDARs' extrinsics would move if one stop counted a little more: `moves[i]` has a column for each stop,
/// [rotation; translation] in T_b_i exp(x), of LiDAR i against `base` (nothing: against the one that is fixed).
struct StopMoves {
  std::vector<Eigen::Matrix<double, 6, Eigen::Dynamic>> moves;
  /// Of each LiDAR: how many stops that say equally much would scatter as little as those in which it saw something.
  std::vector<double> stops;
};

/// By one Newton step from the minimum, `inverse_hessian` being that of the whole cost in `layout`'s parameters, with
/// the planes following: clusters in a sandwich of covariances.
[[nodiscard]] StopMoves stop_moves(const std::vector<PlaneFeature>& features, const RigState& state,
                                   const ParameterLayout& layout, const Eigen::MatrixXd& inverse_hessian,
                                   std::optional<int> base);

/// Residuals within a stop may agree with each other where a mount moves between stops, or a stop is laid wrongly: the
/// covariance of independent ones is too small then, and what differs from stop to stop tells it. By the direction that
/// scatters most, where that is more than comes by chance in one of a hundred; fewer than `least_scattering_stops`
/// tell nothing.
[[nodiscard]] StopScatter stop_scatter(const Eigen::Matrix<double, 6, Eigen::Dynamic>& moves, double stops,
                                       const Matrix6d& covariance);
constexpr double least_scattering_stops = 4.0;

/// The covariance that is wider by that.
[[nodiscard]] Matrix6d widened(const Matrix6d& covariance, const StopScatter& scatter);

}  // namespace rigcal
