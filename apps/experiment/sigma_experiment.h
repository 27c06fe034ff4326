#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"
#include "core/quality/result.h"

namespace rigcal {

/// Which errors the units of the rigs of a row have beyond noise.
struct SigmaCase {
  std::string name;
  double range_bias_m = 0.0;     ///< Sigma of each unit's constant.
  double footprint_share = 0.0;  ///< Of the shots that bleed over edges.
};

/// The squared error of one LiDAR in units of its sigma (NEES, six degrees of freedom).
struct SigmaTrial {
  std::string scene;
  double nees = 0.0;
  double translation_m = 0.0;
  double rotation_rad = 0.0;
  Status status = Status::good;
};

/// One kind of errors over all scenes.
struct SigmaRow {
  SigmaCase kind;
  int rigs = 0;
  int failed = 0;  ///< LiDARs without an answer; they are not in `trials`.
  std::vector<SigmaTrial> trials;
};

/// What the trials of one scene, or of all (empty name), come to.
struct SigmaFigures {
  int lidars = 0;
  int good = 0;
  double mean_nees = 0.0;       ///< 6 where sigma is true.
  double within_95 = 0.0;       ///< Share of errors in the 95 % ellipsoid,
  double within_68 = 0.0;       ///< and in that of 68 %.
  double good_within_95 = 0.0;  ///< Of those called good.
  int false_alarms = 0;         ///< Within what `good` asks for, and not called good.
  double median_m = 0.0;
  double median_rad = 0.0;
};
[[nodiscard]] SigmaFigures sigma_figures(const SigmaRow& row, const std::string& scene);

struct SigmaExperimentOptions {
  int rigs = 60;
  std::uint64_t seed = 1;
  int points = 20000;  ///< Of a patch.
};

/// Calibrates `rigs` rigs of 12 to 24 stops, in turn in a courtyard, a room and a sparse field, in memory, for each
/// kind of errors: none beyond noise, and 10 mm of range bias a unit with whole footprints. Rigs run side by side on
/// all threads; no figure depends on how many there are. Errors: cancelled.
[[nodiscard]] Expected<std::vector<SigmaRow>> try_sigmas(const SigmaExperimentOptions& options,
                                                         const RunContext& context);

[[nodiscard]] std::string sigma_experiment_text(const std::vector<SigmaRow>& rows);
[[nodiscard]] std::string sigma_experiment_json(const std::vector<SigmaRow>& rows);

/// Share of errors below each NEES against what a true sigma gives (chi-square, 6 degrees of freedom), as an SVG file.
[[nodiscard]] std::string nees_svg(const std::vector<SigmaRow>& rows);

}  // namespace rigcal
