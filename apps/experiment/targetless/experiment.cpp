#include "apps/experiment/targetless/experiment.h"

#include "apps/experiment/parts.h"

namespace rigcal::targetless {
namespace {

constexpr int iterations_trials = 10;
constexpr int basin_trials = 4;
constexpr int chain_trials = 1;
constexpr int cameras_trials = 3;

LidarExperimentOptions lidar_options(const ExperimentOptions& options, int trials) {
  LidarExperimentOptions out;
  out.trials = options.trials.value_or(trials);
  out.seed = options.seed;
  out.points = options.points.value_or(out.points);
  return out;
}

CameraSetOptions camera_options(const ExperimentOptions& options) {
  CameraSetOptions out;
  out.seed = options.seed;
  out.points = options.points.value_or(out.points);
  return out;
}

}  // namespace

std::vector<std::string> part_names() { return {"iterations", "basin", "chain", "time", "cameras"}; }

Expected<Experiment> run_parts(const ExperimentOptions& options, const RunContext& context) {
  Experiment out;
  if (is_wanted("iterations", options.parts)) {
    Expected<IterationsExperiment> done = try_iterations(lidar_options(options, iterations_trials), context);
    if (!done) return done.error();
    out.iterations = std::move(*done);
  }
  if (is_wanted("basin", options.parts)) {
    Expected<std::vector<BasinCell>> done = try_basin(lidar_options(options, basin_trials), context);
    if (!done) return done.error();
    out.basin = std::move(*done);
  }
  if (is_wanted("chain", options.parts)) {
    Expected<std::vector<ChainRow>> done = try_chain(lidar_options(options, chain_trials), context);
    if (!done) return done.error();
    out.chain = std::move(*done);
  }
  if (is_wanted("time", options.parts)) {
    Expected<TimeExperiment> done = measure_times(lidar_options(options, 1), context);
    if (!done) return done.error();
    out.time = std::move(*done);
    Expected<std::vector<CameraSeconds>> cameras = measure_cameras(camera_options(options), context);
    if (!cameras) return cameras.error();
    out.camera_time = std::move(*cameras);
  }
  if (is_wanted("cameras", options.parts)) {
    Expected<CameraExperiment> done =
        try_cameras(options.trials.value_or(cameras_trials), camera_options(options), context);
    if (!done) return done.error();
    out.cameras = std::move(*done);
  }
  return out;
}

}  // namespace rigcal::targetless
