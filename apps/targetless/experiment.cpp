#include "apps/targetless/experiment.h"

#include <algorithm>

namespace rigcal::targetless {
namespace {

constexpr int iterations_trials = 10;
constexpr int basin_trials = 4;

LidarExperimentOptions lidar_options(const ExperimentOptions& options, int trials) {
  LidarExperimentOptions out;
  out.trials = options.trials.value_or(trials);
  out.seed = options.seed;
  out.points = options.points;
  return out;
}

}  // namespace

std::vector<std::string> part_names() { return {"iterations", "basin"}; }

Expected<Experiment> run_parts(const ExperimentOptions& options, const RunContext& context) {
  const auto wanted = [&](const char* part) {
    return options.parts.empty() || std::find(options.parts.begin(), options.parts.end(), part) != options.parts.end();
  };
  Experiment out;
  if (wanted("iterations")) {
    Expected<IterationsExperiment> done = try_iterations(lidar_options(options, iterations_trials), context);
    if (!done) return done.error();
    out.iterations = std::move(*done);
  }
  if (wanted("basin")) {
    Expected<std::vector<BasinCell>> done = try_basin(lidar_options(options, basin_trials), context);
    if (!done) return done.error();
    out.basin = std::move(*done);
  }
  return out;
}

}  // namespace rigcal::targetless
