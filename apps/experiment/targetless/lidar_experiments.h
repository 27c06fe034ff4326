#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal::targetless {

struct MeanSpread {
  double mean = 0.0;
  double spread = 0.0;  ///< Standard deviation over the trials.
};

[[nodiscard]] MeanSpread mean_spread(const std::vector<double>& values);

/// Over all trials, of the mean error of a rig's extrinsics.
struct IterationFigures {
  MeanSpread rotation_rad;
  MeanSpread translation_m;
  int right = 0;  ///< Trials in which every LiDAR is within 2 cm and 0.2 degrees.
};

struct MethodIterations {
  std::string method;
  std::vector<IterationFigures> after;  ///< Of iteration 0 (the guess), 1, ...
  /// Iterations until the slowest of the trials that get right is so for good; none where none does.
  std::optional<int> most_to_be_right;
  double iteration_s = 0.0;  ///< Mean over all iterations.
  double seconds = 0.0;      ///< Mean of a trial.
};

struct Trial;
[[nodiscard]] MethodIterations iterations_of(const std::string& method, const std::vector<Trial>& trials);

/// Fig. 10: error against iteration.
struct IterationsExperiment {
  int trials = 0;
  MeanSpread guess_rotation_rad;  ///< Of single extrinsics, as the paper tells them.
  MeanSpread guess_translation_m;
  std::vector<MethodIterations> methods;
};

/// Fig. 11: one method from guesses of one size.
struct BasinCell {
  std::string method;
  double rotation_deg = 0.0;
  double translation_m = 0.0;
  int trials = 0;
  int right = 0;
  double median_rotation_rad = 0.0;  ///< At the end, of the trials that are right.
  double median_translation_m = 0.0;
};

struct LidarExperimentOptions {
  int trials = 10;
  std::uint64_t seed = 1;
  int points = 20000;  ///< Of a patch.
  int stops = 20;
  std::vector<std::string> scenes;  ///< Only these; empty: all of the experiment's own.
};

/// From 10 degrees and 0.2 m, the scenes in turns. Errors: cancelled.
[[nodiscard]] Expected<IterationsExperiment> try_iterations(const LidarExperimentOptions& options,
                                                            const RunContext& context);

/// From 10, 20 and 30 degrees by 0.5, 1, 2 and 4 m. Errors: cancelled.
[[nodiscard]] Expected<std::vector<BasinCell>> try_basin(const LidarExperimentOptions& options,
                                                         const RunContext& context);

}  // namespace rigcal::targetless
