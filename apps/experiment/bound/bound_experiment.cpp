#include "apps/experiment/bound/bound_experiment.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/experiment/bound/light_rig_bound.h"
#include "apps/experiment/experiment_json.h"
#include "apps/experiment/independent_trials.h"
#include "apps/experiment/light_runs.h"
#include "core/base/median.h"
#include "core/geometry/matrix6.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::bound {
namespace {

using Json = nlohmann::ordered_json;

struct RigTrials {
  int failed = 0;
  std::vector<BoundTrial> trials;
};

Expected<RigTrials> try_rig(std::uint64_t seed, int points, const RunContext& context) {
  const std::string scene_name = light_run_scenes[seed % light_run_scenes.size()];
  const Expected<sim::Scene> scene = sim::load_scene(scene_name);
  if (!scene) return scene.error();
  const sim::LightRigOptions light_options = sigma_run(seed, points, 0.0, 0.0);
  Expected<sim::LightRig> light = sim::make_light_rig(*scene, light_options);
  if (!light) return light.error();
  const auto bounds = bound_of_light_rig(*scene, *light);
  const auto pieces = bound_of_light_rig(*scene, *light, {piece_m});
  const Expected<CalibrationResult> result = calibrate_from_guesses(*light, context);
  if (!result) return result.error();
  RigTrials out;
  for (std::size_t i = 0; i < result->sensors.size(); ++i) {
    const SensorResult& sensor = result->sensors[i];
    const std::optional<Matrix6d>& bound = bounds[i];
    if (sensor.name == result->base) continue;
    const std::optional<Matrix6d>& in_pieces = pieces[i];
    if (!sensor.T_base_sensor || !bound || !in_pieces) {
      ++out.failed;
      continue;
    }
    const Vector6d xi = (light->T_base_sensor[i].inverse() * *sensor.T_base_sensor).log();
    out.trials.push_back({scene_name, seed, sensor.name, sensor.status,
                          sensor.T_base_sensor->t - light->T_base_sensor[i].t, light->T_base_sensor[i].R * xi.head<3>(),
                          xi.tail<3>().squaredNorm(), xi.head<3>().squaredNorm(), bound->diagonal().tail<3>().sum(),
                          bound->diagonal().head<3>().sum(), in_pieces->diagonal().tail<3>().sum(),
                          in_pieces->diagonal().head<3>().sum(), sensor.covariance.diagonal().tail<3>().sum(),
                          sensor.covariance.diagonal().head<3>().sum(), xi.dot(solve_symmetric6(*bound, xi))});
  }
  return out;
}

std::vector<std::string> scenes_of(const BoundExperiment& experiment) {
  std::set<std::string> names;
  for (const BoundTrial& trial : experiment.trials) names.insert(trial.scene);
  std::vector<std::string> out(names.begin(), names.end());
  out.emplace_back();
  return out;
}

}  // namespace

Expected<BoundExperiment> try_bounds(const BoundExperimentOptions& options, const RunContext& context) {
  SilentReporter silent;
  const RunContext quiet{silent, context.stop};
  std::vector<RigTrials> tried(static_cast<std::size_t>(options.rigs));
  const auto done = independent_trials(options.rigs, "bound", context, [&](int k) -> Expected<void> {
    Expected<RigTrials> one = try_rig(options.seed + static_cast<std::uint64_t>(k), options.points, quiet);
    if (!one) return one.error();
    tried[static_cast<std::size_t>(k)] = std::move(*one);
    return {};
  });
  if (!done) return done.error();
  BoundExperiment experiment{options, 0, {}};
  for (const RigTrials& rig : tried) {
    experiment.failed += rig.failed;
    experiment.trials.insert(experiment.trials.end(), rig.trials.begin(), rig.trials.end());
  }
  return experiment;
}

BoundFigures bound_figures(const BoundExperiment& experiment, const std::string& scene) {
  BoundFigures out;
  std::vector<double> bound_mm;
  std::vector<double> bound_deg;
  std::vector<double> error_mm;
  std::vector<double> error_deg;
  for (const BoundTrial& trial : experiment.trials) {
    if (!scene.empty() && trial.scene != scene) continue;
    ++out.lidars;
    out.ratio_m += trial.error_m2 / trial.bound_m2;
    out.ratio_rad += trial.error_rad2 / trial.bound_rad2;
    out.ratio += trial.whitened / 6.0;
    out.pieces_ratio_m += trial.error_m2 / trial.pieces_m2;
    out.pieces_ratio_rad += trial.error_rad2 / trial.pieces_rad2;
    out.sigma_ratio_m += trial.sigma_m2 / trial.bound_m2;
    out.sigma_ratio_rad += trial.sigma_rad2 / trial.bound_rad2;
    bound_mm.push_back(1e3 * std::sqrt(trial.bound_m2));
    bound_deg.push_back(to_deg(std::sqrt(trial.bound_rad2)));
    error_mm.push_back(1e3 * std::sqrt(trial.error_m2));
    error_deg.push_back(to_deg(std::sqrt(trial.error_rad2)));
  }
  if (out.lidars == 0) return out;
  for (double* value : {&out.ratio_m, &out.ratio_rad, &out.ratio, &out.pieces_ratio_m, &out.pieces_ratio_rad,
                        &out.sigma_ratio_m, &out.sigma_ratio_rad})
    *value = std::sqrt(*value / out.lidars);
  out.bound_mm = median(std::move(bound_mm));
  out.bound_deg = median(std::move(bound_deg));
  out.error_mm = median(std::move(error_mm));
  out.error_deg = median(std::move(error_deg));
  return out;
}

std::string bound_experiment_text(const BoundExperiment& experiment) {
  std::string text = fmt::format(
      "Errors of LiDARs over the Cramer-Rao bound of the simulated noise (surfaces told, planes and poses unknown),\n"
      "root mean squares; {} rigs, {} points a patch{}\n"
      "                     error over bound    over that of pieces   sigma over bound           median error          "
      " "
      "median bound\n"
      "scene       LiDARs   shift   turn   both     shift   turn        shift   turn\n",
      experiment.options.rigs, experiment.options.points,
      experiment.failed > 0 ? fmt::format(", {} LiDARs without an answer", experiment.failed) : "");
  for (const std::string& scene : scenes_of(experiment)) {
    const BoundFigures f = bound_figures(experiment, scene);
    text += fmt::format(
        "{:<11} {:>6} {:>7.2f} {:>6.2f} {:>6.2f}   {:>7.2f} {:>6.2f}     {:>7.2f} {:>6.2f}     {:>6.3f} mm {:.5f} deg  "
        "{:>6.3f} mm "
        "{:.5f} deg\n",
        scene.empty() ? "all" : scene, f.lidars, f.ratio_m, f.ratio_rad, f.ratio, f.pieces_ratio_m, f.pieces_ratio_rad,
        f.sigma_ratio_m, f.sigma_ratio_rad, f.error_mm, f.error_deg, f.bound_mm, f.bound_deg);
  }
  return text;
}

std::string bound_experiment_json(const BoundExperiment& experiment) {
  Json json = experiment_head("bound");
  json["rigs"] = experiment.options.rigs;
  json["seed"] = experiment.options.seed;
  json["points"] = experiment.options.points;
  json["failed"] = experiment.failed;
  json["scenes"] = Json::array();
  for (const std::string& scene : scenes_of(experiment)) {
    const BoundFigures f = bound_figures(experiment, scene);
    json["scenes"].push_back({{"scene", scene.empty() ? "all" : scene},
                              {"lidars", f.lidars},
                              {"ratio_translation", f.ratio_m},
                              {"ratio_rotation", f.ratio_rad},
                              {"ratio", f.ratio},
                              {"pieces_ratio_translation", f.pieces_ratio_m},
                              {"pieces_ratio_rotation", f.pieces_ratio_rad},
                              {"sigma_ratio_translation", f.sigma_ratio_m},
                              {"sigma_ratio_rotation", f.sigma_ratio_rad},
                              {"median_error_mm", f.error_mm},
                              {"median_error_deg", f.error_deg},
                              {"median_bound_mm", f.bound_mm},
                              {"median_bound_deg", f.bound_deg}});
  }
  json["trials"] = Json::array();
  for (const BoundTrial& trial : experiment.trials) {
    json["trials"].push_back(
        {{"scene", trial.scene},
         {"seed", trial.seed},
         {"lidar", trial.lidar},
         {"status", to_string(trial.status)},
         {"shift_mm", {1e3 * trial.shift_m.x(), 1e3 * trial.shift_m.y(), 1e3 * trial.shift_m.z()}},
         {"turn_deg", {to_deg(trial.turn_rad.x()), to_deg(trial.turn_rad.y()), to_deg(trial.turn_rad.z())}},
         {"error_mm", 1e3 * std::sqrt(trial.error_m2)},
         {"error_deg", to_deg(std::sqrt(trial.error_rad2))},
         {"bound_mm", 1e3 * std::sqrt(trial.bound_m2)},
         {"bound_deg", to_deg(std::sqrt(trial.bound_rad2))},
         {"pieces_bound_mm", 1e3 * std::sqrt(trial.pieces_m2)},
         {"pieces_bound_deg", to_deg(std::sqrt(trial.pieces_rad2))},
         {"sigma_mm", 1e3 * std::sqrt(trial.sigma_m2)},
         {"sigma_deg", to_deg(std::sqrt(trial.sigma_rad2))},
         {"whitened", trial.whitened}});
  }
  return json_text(json);
}

}  // namespace rigcal::bound
