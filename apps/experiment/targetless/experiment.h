#pragma once

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/experiment/targetless/camera_experiment.h"
#include "apps/experiment/targetless/chain_experiment.h"
#include "apps/experiment/targetless/lidar_experiments.h"
#include "apps/experiment/targetless/time_experiment.h"

namespace rigcal::targetless {

/// The experiments of the targetless paper; parts that were not asked for are empty.
struct Experiment {
  std::optional<IterationsExperiment> iterations;
  std::vector<BasinCell> basin;
  std::vector<ChainRow> chain;
  std::optional<TimeExperiment> time;
  std::vector<CameraSeconds> camera_time;
  std::optional<CameraExperiment> cameras;
};

struct ExperimentOptions {
  std::vector<std::string> parts;  ///< Names; empty: all.
  std::optional<int> trials;       ///< Else each part's own.
  std::uint64_t seed = 1;
  std::optional<int> points;  ///< Of a patch; else 20000, 100000 for cameras.
};

/// The names that `ExperimentOptions::parts` may have.
[[nodiscard]] std::vector<std::string> part_names();

/// Errors: cancelled.
[[nodiscard]] Expected<Experiment> run_parts(const ExperimentOptions& options, const RunContext& context);

/// Tables for people, the paper's figures beside ours.
[[nodiscard]] std::string experiment_text(const Experiment& experiment);
/// See docs/schema/experiment_targetless.json.
[[nodiscard]] std::string experiment_json(const Experiment& experiment);
/// Names and contents of what is written into a folder beside the two above: tables as CSV, pictures.
[[nodiscard]] std::vector<std::pair<std::string, std::string>> experiment_files(const Experiment& experiment);
/// All names that there may be.
[[nodiscard]] std::vector<std::string> experiment_file_names();

}  // namespace rigcal::targetless
