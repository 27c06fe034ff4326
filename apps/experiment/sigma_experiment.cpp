#include "apps/experiment/sigma_experiment.h"

#include <array>

#include "apps/experiment/independent_trials.h"
#include "apps/experiment/light_runs.h"
#include "core/base/median.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/matrix6.h"
#include "core/pipeline/lidar_calibration.h"
#include "simdata/rig/light_rig.h"
#include "simdata/scene/scene_file.h"

namespace rigcal {
namespace {

const std::array<SigmaCase, 2>& cases() {
  static const std::array<SigmaCase, 2> all{
      {{"noise alone", 0.0, 0.0}, {"10 mm of range bias, whole footprints", 0.010, 1.0}}};
  return all;
}

// What one rig comes to.
struct RigTrials {
  int failed = 0;
  std::vector<SigmaTrial> trials;
};

Expected<RigTrials> try_rig(const SigmaCase& kind, int points, std::uint64_t seed, const RunContext& context) {
  const std::string scene_name = light_run_scenes[seed % light_run_scenes.size()];
  const Expected<sim::Scene> scene = sim::load_scene(scene_name);
  if (!scene) return scene.error();
  const sim::LightRigOptions light_options = sigma_run(seed, points, kind.range_bias_m, kind.footprint_share);
  Expected<sim::LightRig> light = sim::make_light_rig(*scene, light_options);
  if (!light) return light.error();
  const Expected<CalibrationResult> result = calibrate_from_guesses(*light, context);
  if (!result) return result.error();
  RigTrials out;
  for (std::size_t i = 0; i < result->sensors.size(); ++i) {
    const SensorResult& sensor = result->sensors[i];
    if (sensor.name == result->base) continue;
    if (!sensor.T_base_sensor) {
      ++out.failed;
      continue;
    }
    const Vector6d xi = (light->T_base_sensor[i].inverse() * *sensor.T_base_sensor).log();
    out.trials.push_back({scene_name, xi.dot(solve_symmetric6(sensor.covariance, xi)), xi.tail<3>().norm(),
                          xi.head<3>().norm(), sensor.status});
  }
  return out;
}

}  // namespace

SigmaFigures sigma_figures(const SigmaRow& row, const std::string& scene) {
  SigmaFigures out;
  std::vector<double> metres;
  std::vector<double> radians;
  double good_within = 0.0;
  for (const SigmaTrial& trial : row.trials) {
    if (!scene.empty() && trial.scene != scene) continue;
    const bool inside = trial.nees <= chi2_95_6;
    ++out.lidars;
    out.mean_nees += trial.nees;
    out.within_95 += inside ? 1.0 : 0.0;
    out.within_68 += trial.nees <= chi2_68_6 ? 1.0 : 0.0;
    metres.push_back(trial.translation_m);
    radians.push_back(trial.rotation_rad);
    if (trial.status != Status::good) {
      const Requirement asked;
      if (trial.translation_m <= asked.translation_m && trial.rotation_rad <= asked.rotation_rad) ++out.false_alarms;
      continue;
    }
    ++out.good;
    good_within += inside ? 1.0 : 0.0;
  }
  if (out.lidars == 0) return out;
  out.mean_nees /= out.lidars;
  out.within_95 /= out.lidars;
  out.within_68 /= out.lidars;
  out.good_within_95 = out.good > 0 ? good_within / out.good : 0.0;
  out.median_m = median(std::move(metres));
  out.median_rad = median(std::move(radians));
  return out;
}

Expected<std::vector<SigmaRow>> try_sigmas(const SigmaExperimentOptions& options, const RunContext& context) {
  std::vector<SigmaRow> rows;
  SilentReporter silent;
  const RunContext quiet{silent, context.stop};
  for (const SigmaCase& kind : cases()) {
    std::vector<RigTrials> tried(static_cast<std::size_t>(options.rigs));
    const auto done = independent_trials(options.rigs, kind.name, context, [&](int k) -> Expected<void> {
      Expected<RigTrials> one = try_rig(kind, options.points, options.seed + static_cast<std::uint64_t>(k), quiet);
      if (!one) return one.error();
      tried[static_cast<std::size_t>(k)] = std::move(*one);
      return {};
    });
    if (!done) return done.error();
    SigmaRow& row = rows.emplace_back();
    row.kind = kind;
    for (const RigTrials& rig : tried) {
      ++row.rigs;
      row.failed += rig.failed;
      row.trials.insert(row.trials.end(), rig.trials.begin(), rig.trials.end());
    }
  }
  return rows;
}

}  // namespace rigcal
