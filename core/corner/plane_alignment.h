#pragma once

#include <span>
#include <vector>

#include "core/corner/fitted_plane.h"

namespace rigcal {

/// One surface as LiDARs a and b saw it. The normals face the same way once b is laid on a.
struct PlanePair {
  FittedPlane a;
  FittedPlane b;
  double weight_a = 1.0;  ///< Of each point of a in the cost, 1/m^2.
  double weight_b = 1.0;
};

/// Residuals of one pair at T_a_b: their squares add up to
///   sum over b's points of weight_b (n_a.(R p + t) - d_a)^2 + sum over a's of weight_a (n_b.R^T (p - t) - d_b)^2
/// less the points' own scatter along their normals, from the moments of the points alone: first four for b's points,
/// then four for a's. `jacobian`, if not null, is by a rotation R exp(phi) and by t.
void pair_residuals(const PlanePair& pair, const SE3& T_a_b, Eigen::Matrix<double, 8, 1>& residuals,
                    Eigen::Matrix<double, 8, 6>* jacobian);

struct PlaneAlignment {
  SE3 T_a_b;
  double cost_before = 0.0;
  double cost_after = 0.0;
  int iterations = 0;
  bool converged = false;
};

/// Lays b's planes on a's and a's on b's at once, by Levenberg-Marquardt from `start`. `robust_scale`: of the Cauchy
/// kernel over the misfit of a whole pair, in sigmas; 0: plain least squares, as published.
[[nodiscard]] PlaneAlignment align_planes(std::span<const PlanePair> pairs, const SE3& start,
                                          double robust_scale = 0.0);

}  // namespace rigcal
