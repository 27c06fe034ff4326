#pragma once

#include <optional>
#include <vector>

#include "core/planes/normal_equations.h"

namespace rigcal {

/// A Gaussian on a pose: (T_prior^-1 T).log() with this information (inverse covariance).
struct PosePrior {
  SE3 T;
  Matrix6d information = Matrix6d::Zero();
};

/// The same sigma along all axes.
[[nodiscard]] PosePrior isotropic_prior(const SE3& T, double rotation_rad, double translation_m);

struct AdjustOptions {
  HessianForm form = HessianForm::gauss_newton;
  int max_iterations = 10;
  /// Converged when no rotation moves by more and no translation by more. Far below what the noise allows.
  double rotation_tolerance_rad = 1e-8;
  double translation_tolerance_m = 1e-7;
  std::vector<std::optional<PosePrior>> stop_priors;   ///< Empty or one for each stop.
  std::vector<std::optional<PosePrior>> lidar_priors;  ///< Empty or one for each LiDAR.
  /// Likewise, but found in the data by other means than planes: counts as data where priors do not.
  std::vector<std::optional<PosePrior>> lidar_matches;
};

struct AdjustSummary {
  bool converged = false;
  int iterations = 0;
  double cost_before = 0.0;
  double cost_after = 0.0;
  std::vector<double> costs;  ///< Before the first iteration and after each.
};

/// Levenberg-Marquardt on the plane costs and priors over the free blocks of `layout`, from and into `state`. Steps
/// that raise the cost are refused; where the exact Hessian is indefinite the Gauss-Newton one takes its place. A free
/// block that nothing holds stays where it is.
AdjustSummary adjust(const std::vector<PlaneFeature>& features, const ParameterLayout& layout,
                     const AdjustOptions& options, RigState& state);

/// Adds the share of the priors and matches at `state` to normal equations.
void add_priors(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state,
                NormalEquations& sum);
/// Of the matches only.
void add_matches(const ParameterLayout& layout, const AdjustOptions& options, const RigState& state,
                 NormalEquations& sum);

}  // namespace rigcal
