#include <nlohmann/json.hpp>

#include "apps/targetless/experiment.h"
#include "core/geometry/se3.h"

namespace rigcal::targetless {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const IterationsExperiment& experiment) {
  Json methods = Json::array();
  for (const MethodIterations& method : experiment.methods) {
    Json after = Json::array();
    for (const IterationFigures& f : method.after) {
      after.push_back({{"rotation_deg", to_deg(f.rotation_rad.mean)},
                       {"rotation_spread_deg", to_deg(f.rotation_rad.spread)},
                       {"translation_m", f.translation_m.mean},
                       {"translation_spread_m", f.translation_m.spread},
                       {"right", f.right}});
    }
    methods.push_back({{"method", method.method},
                       {"most_to_be_right", method.most_to_be_right},
                       {"iteration_s", method.iteration_s},
                       {"seconds", method.seconds},
                       {"after", after}});
  }
  return {{"trials", experiment.trials},
          {"guess_rotation_deg", to_deg(experiment.guess_rotation_rad.mean)},
          {"guess_rotation_spread_deg", to_deg(experiment.guess_rotation_rad.spread)},
          {"guess_translation_m", experiment.guess_translation_m.mean},
          {"guess_translation_spread_m", experiment.guess_translation_m.spread},
          {"methods", methods}};
}

Json json_of(const BasinCell& cell) {
  return {{"rotation_deg", cell.rotation_deg},
          {"translation_m", cell.translation_m},
          {"method", cell.method},
          {"trials", cell.trials},
          {"right", cell.right},
          {"median_rotation_deg", to_deg(cell.median_rotation_rad)},
          {"median_translation_m", cell.median_translation_m}};
}

}  // namespace

std::string experiment_json(const Experiment& experiment) {
  Json json{{"rigcal", 1}, {"command", "experiment"}, {"experiment", "targetless"}};
  if (experiment.iterations) json["iterations"] = json_of(*experiment.iterations);
  if (!experiment.basin.empty()) {
    json["basin"] = Json::array();
    for (const BasinCell& cell : experiment.basin) json["basin"].push_back(json_of(cell));
  }
  return json.dump(2) + "\n";
}

}  // namespace rigcal::targetless
