#pragma once

#include <array>
#include <vector>

#include "core/planes/adjust.h"
#include "core/voxel/range_correction.h"

namespace rigcal {

/// What the ranges of each LiDAR may have wrong in every shot: nothing, the same everywhere (a constant of each unit),
/// more the darker a surface is (with white as it should be), or both.
enum class RangeLaw : unsigned { none = 0, constant = 1, by_darkness = 2, both = 3 };

inline constexpr std::array<RangeLaw, 4> all_range_laws{RangeLaw::none, RangeLaw::constant, RangeLaw::by_darkness,
                                                        RangeLaw::both};

/// Whether `law` allows for all that `other` does.
[[nodiscard]] constexpr bool covers(RangeLaw law, RangeLaw other) {
  return (static_cast<unsigned>(law) & static_cast<unsigned>(other)) == static_cast<unsigned>(other);
}

/// What was found and taken out of the ranges of each LiDAR, and under which law.
struct RangeCorrection {
  RangeLaw law = RangeLaw::none;
  std::vector<RangeError> errors;  ///< One for each LiDAR; empty: nothing was taken out.
};

/// What the planes say under one law. Numbers of 2 L parameters: RangeError::white_m of each LiDAR, then its black_m.
struct RangeFit {
  /// How likely this law is against the others, even odds before: by the evidence of each for the same data.
  double likely = 0.25;
  Eigen::VectorXd step_m;  ///< Ranges are too long by so much more than what was taken out already; 0 what is not free.
  /// Of these, by the noise of the planes' weights and the prior, and by how well that noise is known: what is taken
  /// out of the scatter of leaves that beams meet aslant tilts them (5 % of noise: 2 mm in all offsets alike).
  Eigen::MatrixXd covariance;

  [[nodiscard]] RangeError step_of(int lidar) const;
  /// Variance of a LiDAR's error on what is so dark, m^2.
  [[nodiscard]] double variance_at(int lidar, double darkness) const;
};

/// What the planes say of errors that are alike in all ranges of a LiDAR, or in all of dark surfaces. A wall seen at an
/// angle to the beam moves less than one that the beam meets head on, so that a wrong range bends flat walls and lays
/// what two LiDARs see of one wall apart: that tells it from a wrong place, the less so the narrower the view. A plane
/// counts as dark as it is in the mean: what is dark within a wall often lies behind it in truth (windows, doors).
struct RangeErrors {
  bool known = false;  ///< The planes carry what is needed (PlaneFeature::rays) and hold all poses.
  std::array<RangeFit, all_range_laws.size()> fits;  ///< By RangeLaw.
  Eigen::MatrixXd shift;  ///< How the free poses and extrinsics move for each metre of a parameter, a column each.
  std::vector<double> darkness;  ///< In the mean, of what each LiDAR sees of planes.

  [[nodiscard]] const RangeFit& fit(RangeLaw law) const { return fits[static_cast<std::size_t>(law)]; }
  /// How likely all laws are together that cover `law`.
  [[nodiscard]] double likely_covering(RangeLaw law) const;
};

/// How large errors usually are, 1 sigma: of a unit's ranges in the mean of what it sees; of what is black against what
/// is white, of all LiDARs alike; and of one unit against the others in that.
struct RangePrior {
  double mean_m = 0.0;
  double black_m = 0.0;
  double own_black_m = 0.0;
};

/// One Gauss-Newton step in all errors of ranges with poses and extrinsics eliminated (Schur complement), at the
/// optimum of `adjust`; not known where the planes have no rays, no parameter is free or the equations have no
/// solution. `taken_out`: what the ranges were shortened by already, of each LiDAR (empty: nothing). The numbers of
/// `prior` are above zero.
[[nodiscard]] RangeErrors find_range_errors(const std::vector<PlaneFeature>& features, const RigState& state,
                                            const ParameterLayout& layout, const AdjustOptions& options,
                                            const std::vector<RangeError>& taken_out, const RangePrior& prior);

/// Cost gradient and Gauss-Newton Hessian with respect to the parameters of RangeFit, and its rows against the free
/// ones of poses and extrinsics.
struct RangeEquations {
  Eigen::VectorXd g;
  Eigen::MatrixXd H;         ///< 2 L x 2 L.
  Eigen::MatrixXd H_cross;   ///< Free parameters x 2 L.
  Eigen::VectorXd weight;    ///< Of all that each LiDAR saw of planes,
  Eigen::VectorXd darkness;  ///< and the sum of weight times darkness.

  RangeEquations& operator+=(const RangeEquations& other);
};

[[nodiscard]] RangeEquations build_range_equations(const std::vector<PlaneFeature>& features, const RigState& state,
                                                   const ParameterLayout& layout);

}  // namespace rigcal
