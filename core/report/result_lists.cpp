// Bare numbers: a line a sensor, and all of a result as JSON.
#include <nlohmann/json.hpp>

#include "core/base/text.h"
#include "core/base/version.h"
#include "core/report/result_texts.h"
#include "core/report/result_writers.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Json json_of(const Eigen::Ref<const Eigen::VectorXd>& values) {
  return std::vector<double>(values.data(), values.data() + values.size());
}

Json rows_of(const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  Json rows = Json::array();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) rows.push_back(json_of(Eigen::VectorXd(matrix.row(i).transpose())));
  return rows;
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

Json json_of(const SensorResult& sensor, bool is_base) {
  Json json{{"status", to_string(sensor.status)}, {"reasons", sensor.reasons}};
  for (const WeakDirection& weak : sensor.weak_directions)
    json["weak_directions"].push_back(Json::parse(weak_direction_json(weak)));
  if (!sensor.T_base_sensor) return json;
  const SE3& T = *sensor.T_base_sensor;
  const Vector6d sigma = sensor.covariance.diagonal().cwiseMax(0.0).cwiseSqrt();
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

std::string mlcc_lines(const PlacedRig& rig) {
  std::string text;
  for (const PlacedSensor& sensor : rig.sensors) {
    const Vector3d& t = sensor.T_base_sensor.t;
    const Eigen::Vector4d q = xyzw_from_rotation(sensor.T_base_sensor.R);
    std::string line;
    for (const double value : {t.x(), t.y(), t.z(), q[3], q[0], q[1], q[2]}) {
      line += (line.empty() ? "" : " ") + number_text(value);
    }
    // Its reader takes what follows a last line end for one more pose.
    text += (text.empty() ? "" : "\n") + line;
  }
  return text;
}

std::string result_json(const CalibrationResult& result, const PlacedRig& placed) {
  Json json{{"rigcal", format_version}, {"base", result.base}};
  if (!result.method.empty()) json["method"] = result.method;
  json["status"] = to_string(result.status);
  json["convention"] = "p_base = R p_sensor + t";
  json["sensors"] = Json::object();
  for (const SensorResult& sensor : result.sensors) {
    json["sensors"][sensor.name] = json_of(sensor, sensor.name == result.base);
  }
  for (const PlacedSensor& sensor : placed.sensors) {
    if (sensor.intrinsics != nullptr) json["sensors"][sensor.name]["intrinsics"] = json_of(*sensor.intrinsics);
  }
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace rigcal
