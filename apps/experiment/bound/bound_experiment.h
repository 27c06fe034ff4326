#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/quality/result.h"

namespace rigcal::bound {

/// One LiDAR of one rig: what it was off by, and what the noise allows. Squares: m^2 and rad^2, summed over the axes.
struct BoundTrial {
  std::string scene;
  std::uint64_t seed = 0;
  std::string lidar;
  Status status = Status::good;
  Vector3d shift_m = Vector3d::Zero();   ///< Estimated less true place, in the base's frame.
  Vector3d turn_rad = Vector3d::Zero();  ///< Rotation vector of R_est R_true^-1, in the base's frame.
  double error_m2 = 0.0;
  double error_rad2 = 0.0;
  double bound_m2 = 0.0;  ///< Trace of the bound.
  double bound_rad2 = 0.0;
  double pieces_m2 = 0.0;  ///< Of the bound where surfaces are cut into pieces of `piece_m`.
  double pieces_rad2 = 0.0;
  double sigma_m2 = 0.0;  ///< Trace of the covariance that the result gives.
  double sigma_rad2 = 0.0;
  double whitened = 0.0;  ///< xi^T bound^-1 xi: 6 on average for an estimator that reaches the bound.
};

/// As large as the largest voxels of the map.
inline constexpr double piece_m = 2.0;

struct BoundExperimentOptions {
  int rigs = 30;
  std::uint64_t seed = 1;
  int points = 20000;  ///< Of a patch.
};

struct BoundExperiment {
  BoundExperimentOptions options;
  int failed = 0;  ///< LiDARs without an answer; they are not in `trials`.
  std::vector<BoundTrial> trials;
};

/// Calibrates `rigs` rigs of 12 to 24 stops, in turn in a courtyard, a room and a sparse field, in memory with noise
/// alone (those of the experiment `sigma`), and puts the errors beside the Cramer-Rao bound. Rigs run side by side on
/// all threads; no figure depends on how many there are. Errors: cancelled.
[[nodiscard]] Expected<BoundExperiment> try_bounds(const BoundExperimentOptions& options, const RunContext& context);

/// What the trials of one scene, or of all (empty name), come to: root mean squares over the LiDARs of each one's error
/// over its own bound.
struct BoundFigures {
  int lidars = 0;
  double ratio_m = 0.0;
  double ratio_rad = 0.0;
  double ratio = 0.0;           ///< Both, in the units of the bound's ellipsoid.
  double pieces_ratio_m = 0.0;  ///< Error over the bound of surfaces in pieces.
  double pieces_ratio_rad = 0.0;
  double sigma_ratio_m = 0.0;  ///< The same of the covariance that results give: what the method leaves unused.
  double sigma_ratio_rad = 0.0;
  double bound_mm = 0.0;  ///< Medians.
  double bound_deg = 0.0;
  double error_mm = 0.0;
  double error_deg = 0.0;
};
[[nodiscard]] BoundFigures bound_figures(const BoundExperiment& experiment, const std::string& scene);

[[nodiscard]] std::string bound_experiment_text(const BoundExperiment& experiment);
[[nodiscard]] std::string bound_experiment_json(const BoundExperiment& experiment);

}  // namespace rigcal::bound
