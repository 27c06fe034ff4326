#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/planes/adjust.h"
#include "core/planes/range_errors.h"
#include "core/quality/result.h"
#include "core/quality/stop_scatter.h"

namespace rigcal {

/// What `good` asks for (95 % bounds), `--require`.
struct Requirement {
  double translation_m = 0.010;
  double rotation_rad = to_rad(0.1);
};

/// The final planes and where they were solved.
struct SolvedPlanes {
  const std::vector<PlaneFeature>& features;
  const RigState& state;
  const ParameterLayout& layout;
  const AdjustOptions& adjust;            ///< With its priors.
  std::optional<RangePrior> ranges = {};  ///< By how much LiDARs may measure too far or too short; none: they do not.
  RangeCorrection corrected = {};
};

/// Of LiDARs that nobody has calibrated: data sheets say 2 to 3 cm, as a bound.
constexpr RangePrior usual_range_errors{0.015, 0.010, 0.001};

/// How sure the planes are of each LiDAR: marginal covariances of the extrinsics, stops marginalised.
struct LidarCovariances {
  /// Of each LiDAR: planes, matches and priors hold it, and the one it is told against, in all directions. Empty: not
  /// of any.
  std::vector<char> observable;
  double chi2 = 0.0;                  ///< Mean square of the observations' offsets over their expected variance.
  std::vector<Matrix6d> with_priors;  ///< One for each LiDAR; zero for the base.
  std::vector<Matrix6d> data_only;    ///< By planes and matches alone: where it is much larger, a prior decided.
  /// Of what each LiDAR's ranges are off by: with a law that goes by darkness on white and on black surfaces, else in
  /// the mean of what it sees. Empty where they were not asked for.
  std::vector<RangeError> range_sigma_m;
  /// The direction of each LiDAR's place (its own frame, unit) that no plane faces and its match holds; zero: none.
  std::vector<Vector3d> only_matched;
  /// By how much the covariances of each LiDAR were widened, as its stops differ.
  std::vector<StopScatter> scatter;
};

/// 2 H^-1 of the Gauss-Newton form (implicit function theorem with weights 1/variance for each point, each cluster
/// capped by the floor of the map), times chi2 where that is above one, and what the LiDARs' ranges may be off by as
/// far as the planes do not tell it (core/planes/range_errors.h). Where stops contradict each other by more, they are
/// as wide as these scatter (stop_scatter.h). A direction of a place or turn that no plane faces is as wide as what
/// else holds it, at most 2 m and 1 rad. All of it is of the poses as they were solved, against the LiDAR that is
/// fixed; told are those against `base` (nothing: the same), by the adjoints.
[[nodiscard]] LidarCovariances lidar_covariances(const SolvedPlanes& solved, std::optional<int> base = std::nullopt);

/// Root mean square over expected noise of what each LiDAR saw in the held-out stops, when its extrinsics come from the
/// other stops: 1 is what noise gives, that of the planes and of the poses without them included.
struct HoldOut {
  std::vector<double> normalised;   ///< One for each LiDAR; 0 where nothing could be held out.
  std::vector<double> rms_m;        ///< The same in metres.
  std::vector<double> start_rms_m;  ///< The same held-out observations at the guess' extrinsics (0: no guess).
  std::vector<SE3> T_base_sensor;   ///< Extrinsics without the held-out stops.
};

/// Every fourth stop is held out for all LiDARs but `base` (with fewer than four stops: every fifth plane); of a LiDAR
/// that saw too little in these every fourth of its own stops (or every fifth plane). The planes and who is on them
/// stay as they are. `guess`: extrinsics before the calibration.
[[nodiscard]] HoldOut hold_out(const SolvedPlanes& solved, int base, const std::vector<SE3>& guess);

/// A direction of the base frame in words, for a reason: "z (up and down) of the base frame", or, where it is no axis
/// of it, "(0.71, 0.70, 0.00) of the base frame".
[[nodiscard]] std::string direction_words(Vector3d d);
/// That of the largest uncertainty of a translation covariance.
[[nodiscard]] std::string weak_translation_words(const Matrix6d& covariance, const SE3& T_base_sensor);

/// 95 % bound of the length of the translation (m) and rotation (rad) error, from the largest axis of the ellipsoids;
/// no number where the covariance is none.
[[nodiscard]] double translation_bound(const Matrix6d& covariance);
[[nodiscard]] double rotation_bound(const Matrix6d& covariance);

}  // namespace rigcal
