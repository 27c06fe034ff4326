#include "apps/experiment/targetless/lidar_experiments.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "apps/experiment/targetless/trials.h"
#include "core/base/median.h"

namespace rigcal::targetless {
namespace {

constexpr std::uint64_t lidar_guess_stream = 901;
constexpr double fig10_deg = 10.0;
constexpr double fig10_m = 0.2;
constexpr int icp_rounds = 30;
constexpr std::array<double, 3> basin_deg{10.0, 20.0, 30.0};
constexpr std::array<double, 4> basin_m{0.5, 1.0, 2.0, 4.0};

Expected<std::vector<Ground>> grounds_of(const LidarExperimentOptions& options, const RunContext& context) {
  GroundOptions grounds;
  grounds.seed = options.seed;
  grounds.points = options.points;
  grounds.stops = options.stops;
  if (!options.scenes.empty()) grounds.scenes = options.scenes;
  return make_grounds(grounds, context);
}

BasinCell count(const std::string& method, const std::vector<Trial>& trials) {
  BasinCell out;
  out.method = method;
  std::vector<double> rotations;
  std::vector<double> translations;
  for (const Trial& trial : trials) {
    ++out.trials;
    if (!trial.is_right(trial.errors.size() - 1)) continue;
    ++out.right;
    rotations.push_back(trial.errors.back().rotation_rad);
    translations.push_back(trial.errors.back().translation_m);
  }
  out.median_rotation_rad = median(std::move(rotations));
  out.median_translation_m = median(std::move(translations));
  return out;
}

}  // namespace

MeanSpread mean_spread(const std::vector<double>& values) {
  MeanSpread out;
  if (values.empty()) return out;
  for (const double value : values) out.mean += value / static_cast<double>(values.size());
  double squares = 0.0;
  for (const double value : values) squares += (value - out.mean) * (value - out.mean);
  if (values.size() > 1) out.spread = std::sqrt(squares / static_cast<double>(values.size() - 1));
  return out;
}

MethodIterations iterations_of(const std::string& method, const std::vector<Trial>& trials) {
  MethodIterations out;
  out.method = method;
  std::size_t longest = 0;
  std::size_t iterations = 0;
  for (const Trial& trial : trials) {
    longest = std::max(longest, trial.errors.size());
    iterations += trial.errors.size() - 1;
    out.seconds += trial.seconds / static_cast<double>(trials.size());
    if (const auto from = trial.right_from()) out.most_to_be_right = std::max(out.most_to_be_right.value_or(0), *from);
  }
  if (iterations > 0)
    out.iteration_s = out.seconds * static_cast<double>(trials.size()) / static_cast<double>(iterations);
  for (std::size_t k = 0; k < longest; ++k) {
    IterationFigures figures;
    std::vector<double> rotations;
    std::vector<double> translations;
    for (const Trial& trial : trials) {
      rotations.push_back(trial.after(k).rotation_rad);
      translations.push_back(trial.after(k).translation_m);
      figures.right += trial.is_right(k) ? 1 : 0;
    }
    figures.rotation_rad = mean_spread(rotations);
    figures.translation_m = mean_spread(translations);
    out.after.push_back(figures);
  }
  return out;
}

Expected<IterationsExperiment> try_iterations(const LidarExperimentOptions& options, const RunContext& context) {
  Expected<std::vector<Ground>> grounds = grounds_of(options, context);
  if (!grounds) return grounds.error();
  IterationsExperiment out;
  out.trials = options.trials;
  std::vector<Trial> ours;
  std::vector<Trial> icp;
  std::vector<double> rotations;
  std::vector<double> translations;
  for (int k = 0; k < options.trials; ++k) {
    context.reporter.progress("iterations", static_cast<double>(k) / options.trials);
    Ground& ground = (*grounds)[static_cast<std::size_t>(k) % grounds->size()];
    Random random(options.seed + static_cast<std::uint64_t>(k), lidar_guess_stream);
    const std::vector<SE3> guess = spoiled(ground.set, fig10_deg, fig10_m, random);
    for (std::size_t i = 0; i < guess.size(); ++i) {
      if (static_cast<int>(i) == ground.set.light.rig.base) continue;
      rotations.push_back(rotation_distance(guess[i].R, ground.set.light.T_base_sensor[i].R));
      translations.push_back((guess[i].t - ground.set.light.T_base_sensor[i].t).norm());
    }
    Expected<Trial> trial = try_ours(ground.set, guess, context);
    if (!trial) return trial.error();
    ours.push_back(std::move(*trial));
    icp.push_back(try_icp(ground, guess, icp_rounds, false, context));
    if (context.cancelled()) return cancelled_error();
  }
  context.reporter.progress("iterations", 1.0);
  out.guess_rotation_rad = mean_spread(rotations);
  out.guess_translation_m = mean_spread(translations);
  out.methods = {iterations_of("rigcal", ours), iterations_of("ICP", icp)};
  return out;
}

Expected<std::vector<BasinCell>> try_basin(const LidarExperimentOptions& options, const RunContext& context) {
  Expected<std::vector<Ground>> grounds = grounds_of(options, context);
  if (!grounds) return grounds.error();
  std::vector<BasinCell> out;
  const double all = static_cast<double>(basin_deg.size() * basin_m.size());
  for (std::size_t cell = 0; cell < basin_deg.size() * basin_m.size(); ++cell) {
    const double deg = basin_deg[cell / basin_m.size()];
    const double m = basin_m[cell % basin_m.size()];
    std::vector<Trial> ours;
    std::vector<Trial> icp;
    for (int k = 0; k < options.trials; ++k) {
      context.reporter.progress("basin", (static_cast<double>(cell) + static_cast<double>(k) / options.trials) / all);
      Ground& ground = (*grounds)[static_cast<std::size_t>(k) % grounds->size()];
      Random random(options.seed + static_cast<std::uint64_t>(k), lidar_guess_stream + 1 + cell);
      const std::vector<SE3> guess = spoiled(ground.set, deg, m, random);
      Expected<Trial> trial = try_ours(ground.set, guess, context);
      if (!trial) return trial.error();
      ours.push_back(std::move(*trial));
      icp.push_back(try_icp(ground, guess, icp_rounds, true, context));
      if (context.cancelled()) return cancelled_error();
    }
    for (BasinCell counted : {count("rigcal", ours), count("ICP", icp)}) {
      counted.rotation_deg = deg;
      counted.translation_m = m;
      out.push_back(std::move(counted));
    }
  }
  context.reporter.progress("basin", 1.0);
  return out;
}

}  // namespace rigcal::targetless
