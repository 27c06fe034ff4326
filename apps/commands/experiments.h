#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/experiment/board_experiment.h"
#include "apps/experiment/sigma_experiment.h"
#include "apps/experiment/start_experiment.h"
#include "core/base/error.h"
#include "core/base/run_context.h"

namespace rigcal {

/// The options of all experiments; which of them read one is told by `Experiment::options`.
struct ExperimentOptions {
  std::optional<int> trials;
  std::optional<int> points;  ///< Of a patch.
  std::optional<int> rigs;
  int mountings = 1000;
  int places = 10;
  StartExperimentOptions start;
  BoardDrawOptions boards;
  int shown = 100;
  std::vector<std::string> parts;  ///< Empty: all.
  bool no_guess = false;
  bool no_gyro = false;
  double scale = 1.0;
  std::string scratch = "rigcal-speed";
  std::uint64_t seed = 1;
  std::string out;
};

/// What came of an experiment.
struct ExperimentFindings {
  std::string text;  ///< Tables for people.
  std::string json;
  /// What `--out` writes beside these two: name and content.
  std::vector<std::pair<std::string, std::string>> files{};
};

/// One of those that `rigcal experiment` knows. To add one: its row in experiments.cpp.
struct Experiment {
  std::string name;
  std::string what;                  ///< For `--help`.
  std::vector<std::string> options;  ///< What it reads of the options that not all read.
  std::vector<std::string> parts;    ///< What `--part` may name.
  std::vector<std::string> files;    ///< Names of all files that there may be.
  Expected<ExperimentFindings> (*run)(const ExperimentOptions& options, const RunContext& context);
};

/// All of them, in the order of `--help`.
[[nodiscard]] const std::vector<Experiment>& experiments();

}  // namespace rigcal
