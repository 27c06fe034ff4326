#include "core/report/result_texts.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "core/base/text.h"
#include "core/base/version.h"
#include "core/report/camera_texts.h"
#include "core/report/matrix_text.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Vector3d rotation_stddev_deg(const SensorResult& sensor) {
  return sensor.covariance.diagonal().head<3>().cwiseSqrt() * (180.0 / pi);
}

Vector3d translation_stddev_m(const SensorResult& sensor) { return sensor.covariance.diagonal().tail<3>().cwiseSqrt(); }

std::string weak_yaml(const WeakDirection& weak) {
  const std::string bound = weak.is_turn ? "deg: " + number_text(to_deg(weak.bound)) : "m: " + number_text(weak.bound);
  return std::string("      - {of: ") + (weak.is_turn ? "turn" : "place") + ", axis: " + list_text(weak.axis) +
         ", bound_" + bound + ", open: " + (weak.is_open ? "true" : "false") +
         ", frozen: " + (weak.is_frozen ? "true" : "false") + ", missing: " + quoted_text(weak.missing) + "}\n";
}

std::string sensor_yaml(const SensorResult& sensor) {
  std::string text = "  " + key_text(sensor.name) + ":\n";
  text += std::string("    status: ") + to_string(sensor.status) + "\n    reasons: [";
  for (std::size_t i = 0; i < sensor.reasons.size(); ++i) {
    text += (i == 0 ? "" : ", ") + quoted_text(sensor.reasons[i]);
  }
  text += "]\n";
  if (!sensor.weak_directions.empty()) text += "    weak_directions:\n";
  for (const WeakDirection& weak : sensor.weak_directions) text += weak_yaml(weak);
  if (!sensor.T_base_sensor) return text;
  const SE3& T = *sensor.T_base_sensor;
  text += "    translation: " + list_text(T.t) + "\n";
  text += "    rotation_xyzw: " + list_text(xyzw_from_rotation(T.R)) + "\n";
  text += "    matrix: " + matrix_text(T.matrix()) + "\n";
  text += "    matrix_inverse: " + matrix_text(T.inverse().matrix()) + "\n";
  text += "    example: {p_sensor: [1, 0, 0], p_base: " + list_text(T * Vector3d(1.0, 0.0, 0.0)) + "}\n";
  text += "    stddev: {translation_m: " + list_text(translation_stddev_m(sensor)) +
          ", rotation_deg: " + list_text(rotation_stddev_deg(sensor)) + "}\n";
  text += "    covariance: " + matrix_text(sensor.covariance) + "\n";
  return text;
}

// Intrinsics are part of a result where they were to be found, too.
std::string refined_yaml(const SensorResult& sensor, const CalibrationResult& result) {
  for (const CameraEvidence& camera : result.cameras) {
    if (camera.name != sensor.name || !camera.refined_intrinsics || !sensor.T_base_sensor) continue;
    return "    intrinsics: " + intrinsics_text(camera.estimate.intrinsics) + "\n";
  }
  return {};
}

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
    const Vector3d mm = translation_stddev_m(sensor) * 1e3;
    const Vector3d deg = rotation_stddev_deg(sensor);
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

// Nine decimals from an integer: a double would keep only some hundred nanoseconds of a UTC time.
std::string seconds_text(std::int64_t stamp_ns) {
  constexpr std::int64_t second_ns = 1'000'000'000;
  std::array<char, 32> text{};
  const std::int64_t seconds = stamp_ns / second_ns;
  const std::int64_t rest = stamp_ns % second_ns;
  std::snprintf(text.data(), text.size(), "%s%lld.%09lld", stamp_ns < 0 ? "-" : "",
                static_cast<long long>(seconds < 0 ? -seconds : seconds),
                static_cast<long long>(rest < 0 ? -rest : rest));
  return text.data();
}

bool has_times(const std::vector<StopPose>& trajectory) {
  return std::any_of(trajectory.begin(), trajectory.end(),
                     [](const StopPose& pose) { return pose.stop.start_ns != 0 || pose.stop.end_ns != 0; });
}

}  // namespace

Expected<void> check_result(const CalibrationResult& result) {
  const auto wrong = [](const std::string& what) {
    return system_error(what, "the result", "please report this as a bug; nothing was written");
  };
  bool has_base = false;
  for (const SensorResult& sensor : result.sensors) {
    has_base = has_base || sensor.name == result.base;
    if (sensor.T_base_sensor.has_value() == (sensor.status == Status::failed)) {
      return wrong(sensor.name + " is " + to_string(sensor.status) + " and has " + (sensor.T_base_sensor ? "a" : "no") +
                   " transform");
    }
    if (!sensor.T_base_sensor) continue;
    if (!sensor.T_base_sensor->matrix().allFinite() || !sensor.covariance.allFinite() ||
        (sensor.covariance.diagonal().array() < 0.0).any()) {
      return wrong("the transform or covariance of " + sensor.name + " is not a finite number");
    }
  }
  for (const StopPose& pose : result.trajectory) {
    if (pose.known && !pose.T_G_base.matrix().allFinite()) {
      return wrong("the pose of stop " + std::to_string(pose.stop.index) + " is not a finite number");
    }
  }
  if (!has_base) return wrong("the base " + result.base + " is not among the sensors");
  return {};
}

std::string extrinsics_yaml(const CalibrationResult& result) {
  std::string text = "rigcal: " + std::to_string(format_version) + "\n";
  text += "base: " + key_text(result.base) + "\n";
  text += "method: " + key_text(result.method) + "\n";
  text += std::string("status: ") + to_string(result.status) + "\n";
  text += "convention: \"p_base = R p_sensor + t\"\n";
  text +=
      "# metres; quaternions [x, y, z, w]; stddev and covariance of xi = [rotation rad; translation m] in T exp(xi),\n";
  text += "# along the axes of the sensor itself\n";
  text += "sensors:\n";
  for (const SensorResult& sensor : result.sensors) text += sensor_yaml(sensor) + refined_yaml(sensor, result);
  return text;
}

std::string trajectory_tum(const CalibrationResult& result) {
  const bool times = has_times(result.trajectory);
  std::string text =
      std::string("# T_G_base, one line a stop: ") + (times ? "stamp_s" : "stop") + " tx ty tz qx qy qz qw\n";
  for (const StopPose& pose : result.trajectory) {
    if (!pose.known) continue;
    const Stop& stop = pose.stop;
    text += times ? seconds_text(stop.start_ns + (stop.end_ns - stop.start_ns) / 2) : std::to_string(stop.index);
    for (const double value : pose.T_G_base.t) text += " " + number_text(value);
    for (const double value : xyzw_from_rotation(pose.T_G_base.R)) text += " " + number_text(value);
    text += "\n";
  }
  return text;
}

std::string report_json(const CalibrationResult& result) {
  Json json{{"rigcal", format_version},
            {"versions", {{"rigcal", version()}, {"compiler", __VERSION__}}},
            {"method", result.method},
            {"base", result.base},
            {"status", to_string(result.status)}};
  json["sensors"] = Json::array();
  for (const SensorResult& sensor : result.sensors) json["sensors"].push_back(sensor_json(sensor));
  const auto known = std::count_if(result.trajectory.begin(), result.trajectory.end(),
                                   [](const StopPose& pose) { return pose.known; });
  json["stops"] = {{"found", result.trajectory.size()}, {"solved", known}};
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
  if (!result.cameras.empty()) json["cameras"] = Json::parse(cameras_json(result));
  if (!result.packets.empty()) json["packets"] = result.packets;
  add_evidence(result, json);
  // A file name in a warning need not be UTF-8: such bytes are replaced, not thrown at the user.
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string weak_direction_json(const WeakDirection& weak) { return weak_json(weak).dump(); }

}  // namespace rigcal
