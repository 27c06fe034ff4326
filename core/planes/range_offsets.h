#pragma once

#include <vector>

#include "core/planes/adjust.h"

namespace rigcal {

/// What the planes say of a constant error in the ranges of each LiDAR. A wall seen at an angle to the beam moves less
/// than one that the beam meets head on, so that a wrong range bends flat walls and lays what two LiDARs see of one
/// wall apart: that tells it from a wrong place, the less so the narrower the view.
struct RangeOffsets {
  bool known = false;      ///< The planes carry what is needed (PlaneFeature::rays) and hold all poses.
  Eigen::VectorXd step_m;  ///< Of each LiDAR: ranges are too long by so much more than what was taken out already.
  /// Of these, by the noise of the planes' weights and the prior, and by how well that noise is known: what is taken
  /// out of the scatter of leaves that beams meet aslant tilts them (5 % of noise: 2 mm in all offsets alike).
  Eigen::MatrixXd covariance;
  /// How likely it is that there are offsets as large as the prior says, against none at all: by the evidence of both
  /// for the same data, even odds before. Tells nothing where some were taken out.
  double likely = 0.5;
  Eigen::MatrixXd shift;  ///< How the free parameters move for each metre of an offset, a column a LiDAR.
};

/// One Gauss-Newton step in all offsets with poses and extrinsics eliminated (Schur complement), at the optimum of
/// `adjust`. `taken_out_m`: what the ranges were shortened by already (empty: nothing); `prior_m`: how large offsets
/// usually are.
[[nodiscard]] RangeOffsets find_range_offsets(const std::vector<PlaneFeature>& features, const RigState& state,
                                              const ParameterLayout& layout, const AdjustOptions& options,
                                              const std::vector<double>& taken_out_m, double prior_m);

/// Cost gradient and Gauss-Newton Hessian with respect to the offsets, and its rows against the free parameters.
struct OffsetEquations {
  Eigen::VectorXd g;
  Eigen::MatrixXd H;        ///< LiDARs x LiDARs.
  Eigen::MatrixXd H_cross;  ///< Free parameters x LiDARs.

  OffsetEquations& operator+=(const OffsetEquations& other);
};

[[nodiscard]] OffsetEquations build_offset_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                                     const ParameterLayout& layout);

}  // namespace rigcal
