#include "core/report/result_formats.h"

#include <algorithm>

#include "core/report/result_writers.h"
#include "core/report/summary_text.h"

namespace rigcal {
namespace {

Status status_of(const ExtrinsicsFile& file, const std::string& name) {
  const auto found = file.status.find(name);
  if (found == file.status.end()) return Status::good;  // A rig file or a ground truth, which say nothing of it.
  if (found->second == to_string(Status::good)) return Status::good;
  return found->second == to_string(Status::weak) ? Status::weak : Status::failed;
}

SensorResult sensor_from(const ExtrinsicsFile& file, const std::string& name) {
  SensorResult sensor;
  sensor.name = name;
  sensor.status = status_of(file, name);
  if (const auto reasons = file.reasons.find(name); reasons != file.reasons.end()) sensor.reasons = reasons->second;
  if (const auto T = file.T_base_sensor.find(name); T != file.T_base_sensor.end()) sensor.T_base_sensor = T->second;
  if (const auto weak = file.weak_directions.find(name); weak != file.weak_directions.end()) {
    for (const ListedDirection& d : weak->second)
      sensor.weak_directions.push_back({d.is_turn, d.axis, d.bound, d.is_open, d.is_frozen, d.missing});
  }
  if (const auto c = file.covariance.find(name); c != file.covariance.end()) sensor.covariance = c->second;
  return sensor;
}

PlacedRig placed_rig(const CalibrationResult& result, const Rig* rig) {
  PlacedRig placed;
  placed.base = result.base;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor) continue;
    PlacedSensor& place = placed.sensors.emplace_back();
    place.name = sensor.name;
    place.T_base_sensor = *sensor.T_base_sensor;
    const int index = rig == nullptr ? -1 : rig->find(sensor.name);
    if (index < 0) continue;
    const Sensor& known = rig->sensors[static_cast<std::size_t>(index)];
    place.is_camera = known.camera.has_value();
    if (known.camera) place.topic = known.camera->topic;
    if (known.camera && known.camera->intrinsics) place.intrinsics = &*known.camera->intrinsics;
  }
  return placed;
}

bool is_camera(const Rig* rig, const std::string& name) {
  const int index = rig == nullptr ? -1 : rig->find(name);
  return index >= 0 && !rig->sensors[static_cast<std::size_t>(index)].is_lidar();
}

/// The cameras, or all sensors where none of the result's is known for a camera. Error: all cameras failed, and LiDARs
/// would be taken for them.
Expected<PlacedRig> cameras_of(const CalibrationResult& result, const Rig* rig, PlacedRig placed) {
  if (std::none_of(result.sensors.begin(), result.sensors.end(),
                   [&](const SensorResult& sensor) { return is_camera(rig, sensor.name); }))
    return placed;
  std::erase_if(placed.sensors, [](const PlacedSensor& sensor) { return !sensor.is_camera; });
  if (!placed.sensors.empty()) return placed;
  return input_error("none of its cameras has a transform, and this format holds cameras only", {},
                     "mend what their reasons say, or choose a format that holds LiDARs, too");
}

/// Kalibr's own words are other ones.
void warn_of_intrinsics(const PlacedRig& rig, std::vector<std::string>& warnings) {
  for (const PlacedSensor& sensor : rig.sensors) {
    if (sensor.is_camera && sensor.intrinsics == nullptr)
      warnings.push_back(sensor.name + " is known without intrinsics and is written without: give --rig RIG with them");
  }
}

/// The LiDARs beside the base.
PlacedRig lidars_around_base(PlacedRig rig) {
  std::erase_if(rig.sensors,
                [&rig](const PlacedSensor& sensor) { return sensor.is_camera || sensor.name == rig.base; });
  return rig;
}

/// Lines without names are told apart by their order alone.
std::optional<Error> missing_line(const CalibrationResult& result, const Rig* rig) {
  for (const SensorResult& sensor : result.sensors) {
    if (sensor.T_base_sensor || is_camera(rig, sensor.name)) continue;
    const std::string why = sensor.reasons.empty() ? "" : " (" + sensor.reasons.front() + ")";
    return input_error(sensor.name + " is failed" + why +
                           ", and the lines of mlcc have no names: without its own those after it would be taken for "
                           "other LiDARs'",
                       {},
                       std::string("mend what its reasons say, or choose a format that has names") +
                           (rig == nullptr || rig->find(sensor.name) < 0 ? "; if it is a camera, add --rig RIG" : ""));
  }
  return std::nullopt;
}

/// Which way the numbers go, as a comment of the format, if it can have one.
void add_convention(ResultFormat format, const PlacedRig& rig, std::string& text) {
  const auto sensor = std::find_if(rig.sensors.begin(), rig.sensors.end(),
                                   [&](const PlacedSensor& each) { return each.name != rig.base; });
  if (sensor == rig.sensors.end()) return;
  const std::string words = "Metres. With T_base_sensor, p_base = R p_sensor + t: " +
                            worked_point_text(sensor->name, sensor->is_camera, rig.base, sensor->T_base_sensor) + ".";
  switch (format) {
    case ResultFormat::autoware:
    case ResultFormat::kalibr:
    case ResultFormat::fast_livo:
      text.insert(0, "# " + words + "\n");
      break;
    case ResultFormat::opencv:  // Behind the two lines that it must begin with.
      text.insert(text.find("---\n") + 4, "# " + words + "\n");
      break;
    case ResultFormat::ros2_tf:
    case ResultFormat::urdf:
      // Two hyphens, which a name may have, end a comment of XML.
      if (words.find("--") == std::string::npos) text.insert(text.find('\n') + 1, "<!-- " + words + " -->\n");
      break;
    case ResultFormat::colmap:
    case ResultFormat::mlcc:
    case ResultFormat::json:
      break;
  }
}

}  // namespace

const std::vector<std::string>& result_format_names() {
  static const std::vector<std::string> names{"ros2-tf", "urdf", "autoware",  "kalibr", "opencv",
                                              "colmap",  "mlcc", "fast-livo", "json"};
  return names;
}

std::optional<ResultFormat> result_format(std::string_view name) {
  const auto& names = result_format_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) return std::nullopt;
  return static_cast<ResultFormat>(found - names.begin());
}

Expected<CalibrationResult> result_from(const ExtrinsicsFile& file, const std::string& place) {
  if (!is_plain_name(file.base)) return input_error("the name of the base cannot stand for a frame", place);
  CalibrationResult result;
  result.base = file.base;
  result.method = file.method;
  for (const std::string& name : file.names) result.sensors.push_back(sensor_from(file, name));
  const bool has_base = std::find(file.names.begin(), file.names.end(), file.base) != file.names.end();
  if (!has_base) {
    SensorResult base = sensor_from(file, file.base);
    base.T_base_sensor = SE3{};
    result.sensors.insert(result.sensors.begin(), base);
  }
  result.is_judged = !file.status.empty();
  result.status = Status::good;
  for (const SensorResult& sensor : result.sensors) result.status = std::max(result.status, sensor.status);
  return result;
}

Expected<ExportedResult> export_result(const CalibrationResult& result, const Rig* rig, ResultFormat format) {
  ExportedResult out;
  PlacedRig placed = placed_rig(result, rig);
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor) out.warnings.push_back(sensor.name + " is failed: it has no transform and is left out");
    if (sensor.status == Status::weak) out.warnings.push_back(sensor.name + " is weak: see its reasons in the result");
  }
  if (format == ResultFormat::kalibr || format == ResultFormat::colmap) {
    Expected<PlacedRig> cameras = cameras_of(result, rig, std::move(placed));
    if (!cameras) return cameras.error();
    placed = *std::move(cameras);
  }
  if (format == ResultFormat::opencv || format == ResultFormat::colmap) warn_of_intrinsics(placed, out.warnings);
  switch (format) {
    case ResultFormat::ros2_tf:
      out.text = ros2_launch(placed);
      break;
    case ResultFormat::urdf:
      out.text = urdf(placed);
      break;
    case ResultFormat::autoware:
      out.text = autoware_yaml(placed);
      break;
    case ResultFormat::kalibr:
      out.text = kalibr_yaml(placed, out.warnings);
      break;
    case ResultFormat::opencv:
      out.text = opencv_yaml(placed);
      break;
    case ResultFormat::colmap:
      out.text = colmap_json(placed);
      break;
    case ResultFormat::mlcc:
      if (const std::optional<Error> missing = missing_line(result, rig)) return *missing;
      placed = lidars_around_base(std::move(placed));
      if (placed.sensors.empty())
        return input_error("has no LiDAR beside its base, and the lines of mlcc are of those alone", {},
                           "choose another format");
      out.text = mlcc_lines(placed);
      break;
    case ResultFormat::fast_livo:
      if (std::none_of(placed.sensors.begin(), placed.sensors.end(),
                       [](const PlacedSensor& sensor) { return !sensor.is_camera; }))
        return input_error("has no LiDAR with a transform, and this format is of a LiDAR and its cameras", {},
                           "choose another format");
      out.text = fast_livo_yaml(placed);
      break;
    case ResultFormat::json:
      out.text = result_json(result, placed);
      break;
  }
  add_convention(format, placed, out.text);
  for (const PlacedSensor& sensor : placed.sensors) out.sensors.push_back(sensor.name);
  return out;
}

}  // namespace rigcal
