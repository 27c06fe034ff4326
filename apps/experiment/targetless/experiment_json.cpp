#include "apps/experiment/experiment_json.h"

#include "apps/experiment/targetless/experiment.h"
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
                       {"most_to_be_right", method.most_to_be_right ? Json(*method.most_to_be_right) : Json()},
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

Json json_of(const ChainRow& row) {
  return {{"rig", row.rig},
          {"scene", row.scene},
          {"method", row.method},
          {"pairs", row.pairs},
          {"found", row.found},
          {"rotation_deg", to_deg(row.rotation_rad.mean)},
          {"rotation_spread_deg", to_deg(row.rotation_rad.spread)},
          {"translation_m", row.translation_m.mean},
          {"translation_spread_m", row.translation_m.spread}};
}

Json json_of(const TimeExperiment& time) {
  Json stages = Json::array();
  for (const StageSeconds& row : time.stages) {
    stages.push_back({{"method", row.method},
                      {"stage", row.stage},
                      {"match_s", row.match_s},
                      {"solve_s", row.solve_s},
                      {"matched", row.matched}});
  }
  return {{"points", time.points},
          {"patches", time.patches},
          {"rigcal_prepare_s", time.ours_prepare_s},
          {"icp_prepare_s", time.icp_prepare_s},
          {"stages", stages}};
}

Json json_of(const CameraSeconds& row) {
  return {{"method", row.method},          {"planes_s", row.planes_s}, {"edges_s", row.edges_s},
          {"match_s", row.match_s},        {"solve_s", row.solve_s},   {"voxels", row.voxels},
          {"edge_points", row.edge_points}};
}

Json json_of(const CameraExperiment& experiment) {
  Json rows = Json::array();
  for (const CameraRow& row : experiment.rows) {
    rows.push_back({{"pair", row.pair},
                    {"lidar", row.lidar},
                    {"overlaps", row.overlaps},
                    {"method", row.method},
                    {"trials", row.trials},
                    {"found", row.found},
                    {"rotation_deg", to_deg(row.rotation_rad.mean)},
                    {"rotation_spread_deg", to_deg(row.rotation_rad.spread)},
                    {"translation_m", row.translation_m.mean},
                    {"translation_spread_m", row.translation_m.spread},
                    {"median_rotation_deg", to_deg(row.median_rotation_rad)},
                    {"median_translation_m", row.median_translation_m},
                    {"seconds", row.seconds}});
  }
  return {{"trials", experiment.trials},
          {"guess_rotation_deg", to_deg(experiment.guess_rotation_rad.mean)},
          {"guess_rotation_spread_deg", to_deg(experiment.guess_rotation_rad.spread)},
          {"guess_translation_m", experiment.guess_translation_m.mean},
          {"guess_translation_spread_m", experiment.guess_translation_m.spread},
          {"rows", rows}};
}

template <class Row>
void put_rows(const char* name, const std::vector<Row>& rows, Json& json) {
  if (rows.empty()) return;
  json[name] = Json::array();
  for (const Row& row : rows) json[name].push_back(json_of(row));
}

}  // namespace

std::string experiment_json(const Experiment& experiment) {
  Json json = experiment_head("targetless");
  if (experiment.iterations) json["iterations"] = json_of(*experiment.iterations);
  put_rows("basin", experiment.basin, json);
  put_rows("chain", experiment.chain, json);
  if (experiment.time) json["time"] = json_of(*experiment.time);
  put_rows("camera_time", experiment.camera_time, json);
  if (experiment.cameras) json["cameras"] = json_of(*experiment.cameras);
  return json_text(json);
}

}  // namespace rigcal::targetless
