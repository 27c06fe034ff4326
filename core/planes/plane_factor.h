#pragma once

#include <functional>
#include <vector>

#include "core/voxel/plane_feature.h"
#include "core/voxel/rig_state.h"

namespace rigcal {

/// Which second derivative: `exact` that of the smallest eigenvalue (may be indefinite far from the optimum),
/// `gauss_newton` the positive semidefinite one with the plane eliminated.
enum class HessianForm { exact, gauss_newton };

/// Derivatives for one observation under p -> Exp(phi) p + tau, in the world frame about the plane's centroid. The cost
/// of a plane is sum_points w (u.(p - q))^2 = N lambda_0 with N, q, lambda_0 of the weighted points: lambda_0 is
/// the least eigenvalue of their covariance, N the sum of their weights. All vectors are [phi; tau].
struct ObservationDerivatives {
  Vector6d g;     ///< Gradient.
  Matrix3d A;     ///< Own block of the Hessian by turns; with shifts it is 2 beta_turn u^T, by these alone 2 N u u^T.
  Vector6d beta;  ///< Coupling by the plane's offset: - (2/N) beta_a beta_b^T.
  Vector6d eta1;  ///< Coupling by its tilt: c1 eta1_a eta1_b^T + c2 eta2_a eta2_b^T.
  Vector6d eta2;
};

struct PlaneDerivatives {
  double cost = 0.0;
  Vector3d centroid = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();
  Vector3d tangent1 = Vector3d::UnitX();  ///< The eigenvectors in the plane.
  Vector3d tangent2 = Vector3d::UnitY();
  Vector3d eigenvalues = Vector3d::Zero();  ///< Of the weighted covariance, ascending, m^2.
  double N = 0.0;                           ///< Sum of the weights.
  double c0 = 0.0, c1 = 0.0, c2 = 0.0;      ///< Factors of the three rank-one couplings (c0 = -2/N).
  std::vector<ObservationDerivatives> observations;
};

/// Cost of the feature at `state`; nothing else.
[[nodiscard]] double plane_cost(const PlaneFeature& feature, const RigState& state);

/// Cost and derivatives at `state`. `out` is reused, so a loop over features allocates once.
void plane_derivatives(const PlaneFeature& feature, const RigState& state, HessianForm form, PlaneDerivatives& out);

/// Calls f(observation, offset in m, freedom) for every observation: how far its mean stands off the plane of all, and
/// the share of that offset which the plane could not take up (1 - leverage): offset^2 is expected to be freedom times
/// the offset's variance.
void for_each_offset(const PlaneFeature& feature, const RigState& state,
                     const std::function<void(const PlaneObservation&, double, double)>& f);

}  // namespace rigcal
