// A result as JSON: the report, and the format `json` of an export.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/version.h"
#include "core/report/result_texts.h"
#include "core/report/result_writers.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

// What is no number, as where a variance is below zero by rounding, is written as null: not known.
Vector6d sigma_of(const SensorResult& sensor) { return sensor.covariance.diagonal().cwiseSqrt(); }

Json weak_json(const WeakDirection& weak) {
  Json json{{"of", weak.is_turn ? "turn" : "place"}, {"axis", {weak.axis.x(), weak.axis.y(), weak.axis.z()}}};
  if (weak.is_turn) json["bound_deg"] = to_deg(weak.bound);
  if (!weak.is_turn) json["bound_m"] = weak.bound;
  json["open"] = weak.is_open;
  json["frozen"] = weak.is_frozen;
  json["missing"] = weak.missing;
  return json;
}

Json sensor_json(const SensorResult& sensor) {
  Json json{{"name", sensor.name}, {"status", to_string(sensor.status)}, {"reasons", sensor.reasons}};
  if (sensor.T_base_sensor) {
    const Vector3d mm = 1e3 * sigma_of(sensor).tail<3>();
    const Vector3d deg = sigma_of(sensor).head<3>() * (180.0 / pi);
    json["stddev_translation_mm"] = {mm.x(), mm.y(), mm.z()};
    json["stddev_rotation_deg"] = {deg.x(), deg.y(), deg.z()};
  }
  for (const WeakDirection& weak : sensor.weak_directions) json["weak_directions"].push_back(weak_json(weak));
  if (sensor.hold_out.ratio > 0.0) {
    const HoldOutFigures& figures = sensor.hold_out;
    json["hold_out"] = {{"over_noise", figures.ratio},
                        {"rms", figures.rms},
                        {"rms_at_guess", figures.start_rms},
                        {"unit", figures.unit}};
  }
  if (sensor.range_offset) {
    json["range_offset"] = {{"mm", 1e3 * sensor.range_offset->value_m},
                            {"sigma_mm", 1e3 * sensor.range_offset->sigma_m}};
  }
  if (sensor.dark_offset) {
    json["dark_offset"] = {{"mm", 1e3 * sensor.dark_offset->value_m}, {"sigma_mm", 1e3 * sensor.dark_offset->sigma_m}};
  }
  if (sensor.noise) {
    json["noise"] = {{"range_mm", 1e3 * sensor.noise->range_m},
                     {"range_mm_per_m", 1e3 * sensor.noise->range_per_m},
                     {"angle_deg", to_deg(sensor.noise->angle_rad)},
                     {"slant_growth", sensor.noise->slant_growth}};
  }
  if (sensor.grid_shift) {
    json["grid_shift"] = {{"mm", 1e3 * sensor.grid_shift->translation_m},
                          {"deg", to_deg(sensor.grid_shift->rotation_rad)}};
  }
  return json;
}

// What the run was made from, and what it changed.
void add_evidence(const CalibrationResult& result, Json& json) {
  if (!result.settings.empty()) {
    json["settings"] = Json::object();
    for (const auto& [name, value] : result.settings) json["settings"][name] = value;
  }
  json["inputs"] = Json::array();
  for (const InputDigest& input : result.inputs) {
    json["inputs"].push_back({{"path", input.path},
                              {"files", input.files},
                              {"bytes", input.bytes},
                              {"sha256", input.sha256},
                              {"in_part", input.in_part}});
  }
  json["shared_surfaces"] = Json::array();
  for (const SharedSurfaces& pair : result.shared_surfaces) {
    const Json sensors = pair.first.empty() ? Json::array() : Json{pair.first, pair.second};
    json["shared_surfaces"].push_back({{"sensors", sensors},
                                       {"surfaces", pair.surfaces},
                                       {"before_mm", 1e3 * pair.before_m},
                                       {"after_mm", 1e3 * pair.after_m}});
  }
  if (result.clocks.empty()) return;
  json["clocks"] = Json::array();
  for (const ClockReport& clock : result.clocks) {
    json["clocks"].push_back({{"sensor", clock.sensor},
                              {"drift_ppm", clock.drift_ppm},
                              {"jitter_us", clock.jitter_us},
                              {"max_delay_us", clock.max_delay_us},
                              {"jumps", clock.jumps},
                              {"strays", clock.strays}});
  }
}

Json stage_json(const StageReport& stage) {
  Json json{{"name", stage.name}, {"wall_s", stage.wall_s}, {"iterations", stage.iterations}};
  // Not finite numbers would be written as null, which is what they are here: not known.
  if (stage.cost_before) json["cost_before"] = *stage.cost_before;
  if (stage.cost_after) json["cost_after"] = *stage.cost_after;
  if (!stage.costs.empty()) json["costs"] = stage.costs;
  json["peak_memory_mb"] = stage.peak_memory_mb;
  Json counts = Json::object();
  for (const auto& [name, value] : stage.counts) counts[name] = value;
  json["counts"] = counts;
  return json;
}

Json between(const SE3& a, const SE3& b) {
  const SE3 difference = a.inverse() * b;
  return {{"mm", 1e3 * difference.t.norm()}, {"deg", to_deg(log_so3(difference.R).norm())}};
}

Json scalar(const ScalarEstimate& estimate) { return {{"value", estimate.value}, {"sigma", estimate.sigma}}; }

Json found_json(const CameraEvidence& camera) {
  const CameraEstimate& e = camera.estimate;
  Json json{{"converged", e.converged},
            {"images_with_edges", e.views_with_edges},
            {"edge_points", e.edge_points},
            {"segments", e.segments},
            {"residual_px", e.residual_px},
            {"hold_out", {{"over_noise", e.hold_out}, {"px", e.hold_out_px}, {"px_at_guess", e.hold_out_start_px}}},
            {"focal_scale", scalar(e.focal_scale)},
            {"k1_change", scalar(e.k1_change)},
            {"cx_change_px", scalar(e.cx_change_px)},
            {"cy_change_px", scalar(e.cy_change_px)},
            {"radial_trend_px", scalar(e.radial_trend)},
            {"halves", {{"mm", 1e3 * e.halves_m}, {"deg", to_deg(e.halves_rad)}, {"chi2", e.halves_chi2}}}};
  if (e.hold_out_share) json["hold_out"]["share"] = *e.hold_out_share;
  if (const FirstAndLast& times = e.first_and_last; times.gain > 0.0) {
    json["first_and_last"] = {
        {"mm", 1e3 * times.apart_m}, {"deg", to_deg(times.apart_rad)}, {"chi2", times.chi2}, {"gain", times.gain}};
  }
  if (camera.guess_T_base_camera) json["from_guess"] = between(e.pose.T_base_camera, *camera.guess_T_base_camera);
  if (e.information) {
    json["information"] = between(e.pose.T_base_camera, e.information->T_base_camera);
    json["information"]["chi2"] = e.disagreement_chi2;
  }
  if (e.runner_up) {
    json["runner_up"] = between(e.pose.T_base_camera, *e.runner_up);
    json["runner_up"]["ratio"] = e.runner_up_ratio;
  }
  return json;
}

Json json_of(const CameraIntrinsics& camera) {
  return {{"model", camera.model == DistortionModel::radtan ? "radtan" : "equidistant"},
          {"width", camera.width},
          {"height", camera.height},
          {"fx", camera.fx},
          {"fy", camera.fy},
          {"cx", camera.cx},
          {"cy", camera.cy},
          {"distortion", camera.distortion}};
}

Json cameras_json(const CalibrationResult& result) {
  Json list = Json::array();
  for (const CameraEvidence& camera : result.cameras) {
    Json json{{"name", camera.name}, {"images", Json::array()}};
    for (const UsedImage& image : camera.images) {
      json["images"].push_back(
          {{"stop", result.trajectory[static_cast<std::size_t>(image.stop)].stop.index}, {"file", image.file}});
    }
    json["found"] = camera.estimate.found;
    const CameraIntrinsics& intrinsics = camera.refined_intrinsics ? camera.estimate.intrinsics : camera.given;
    if (intrinsics.width > 0) json["intrinsics"] = json_of(intrinsics);
    json["wall_s"] = camera.estimate.wall_s;
    json["iterations"] = camera.estimate.iterations;
    if (camera.estimate.found) json.update(found_json(camera));
    list.push_back(json);
  }
  return list;
}

Json json_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

Json rows_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back(json_of(Eigen::VectorXd(matrix.row(i).transpose())));
  return rows;
}

Json json_of(const SensorResult& sensor, bool is_base, bool is_judged) {
  Json json;
  if (is_judged) json["status"] = to_string(sensor.status);
  json["reasons"] = sensor.reasons;
  for (const WeakDirection& weak : sensor.weak_directions) json["weak_directions"].push_back(weak_json(weak));
  if (!sensor.T_base_sensor) return json;
  const SE3& T = *sensor.T_base_sensor;
  const Vector6d sigma = sigma_of(sensor);
  json["translation"] = json_of(T.t);
  json["rotation_xyzw"] = json_of(xyzw_from_rotation(T.R));
  json["matrix"] = rows_of(T.matrix());
  json["matrix_inverse"] = rows_of(T.inverse().matrix());
  json["example"] = {{"p_sensor", {1, 0, 0}}, {"p_base", json_of(T * Vector3d(1.0, 0.0, 0.0))}};
  // A rig file or a ground truth has transforms without a covariance, which is not the same as knowing them exactly.
  if (!is_base && sensor.covariance.isZero(0.0)) return json;
  json["stddev"] = {{"translation_m", json_of(sigma.tail<3>())},
                    {"rotation_deg", json_of(sigma.head<3>() * (180.0 / pi))}};
  json["covariance"] = rows_of(sensor.covariance);
  return json;
}

}  // namespace

std::string report_json(const CalibrationResult& result) {
  Json json{{"rigcal", format_version},
            {"versions", {{"rigcal", version()}, {"compiler", __VERSION__}}},
            {"method", result.method},
            {"base", result.base},
            {"status", to_string(result.status)}};
  json["sensors"] = Json::array();
  for (const SensorResult& sensor : result.sensors) json["sensors"].push_back(sensor_json(sensor));
  const auto used = std::count_if(result.trajectory.begin(), result.trajectory.end(),
                                  [](const StopPose& pose) { return pose.is_used(); });
  json["stops"] = {{"found", result.trajectory.size()}, {"solved", used}};
  json["map_points"] = result.map.size();
  double wall_s = 0.0;
  double peak_mb = 0.0;
  json["stages"] = Json::array();
  for (const StageReport& stage : result.stages) {
    wall_s += stage.wall_s;
    peak_mb = std::max(peak_mb, stage.peak_memory_mb);
    json["stages"].push_back(stage_json(stage));
  }
  json["wall_s"] = wall_s;
  json["peak_memory_mb"] = peak_mb;
  json["warnings"] = result.warnings;
  if (!result.cameras.empty()) json["cameras"] = cameras_json(result);
  if (!result.packets.empty()) json["packets"] = result.packets;
  add_evidence(result, json);
  // A file name in a warning need not be UTF-8: such bytes are replaced, not thrown at the user.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string result_json(const CalibrationResult& result, const PlacedRig& placed) {
  Json json{{"rigcal", format_version}, {"base", result.base}};
  if (!result.method.empty()) json["method"] = result.method;
  if (result.is_judged) json["status"] = to_string(result.status);
  json["convention"] = "p_base = R p_sensor + t";
  json["sensors"] = Json::object();
  for (const SensorResult& sensor : result.sensors) {
    json["sensors"][sensor.name] = json_of(sensor, sensor.name == result.base, result.is_judged);
  }
  for (const PlacedSensor& sensor : placed.sensors) {
    if (sensor.intrinsics != nullptr) json["sensors"][sensor.name]["intrinsics"] = json_of(*sensor.intrinsics);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rigcal
