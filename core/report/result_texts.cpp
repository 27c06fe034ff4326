#include "core/report/result_texts.h"

#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/base/version.h"
#include "core/io/tum_file.h"
#include "core/report/matrix_text.h"

namespace rigcal {
namespace {

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

std::string intrinsics_text(const CameraIntrinsics& intrinsics) {
  const auto entry = [](const char* key, double value) { return std::string(", ") + key + ": " + number_text(value); };
  return std::string("{model: ") + (intrinsics.model == DistortionModel::radtan ? "radtan" : "equidistant") +
         ", width: " + std::to_string(intrinsics.width) + ", height: " + std::to_string(intrinsics.height) +
         entry("fx", intrinsics.fx) + entry("fy", intrinsics.fy) + entry("cx", intrinsics.cx) +
         entry("cy", intrinsics.cy) + ", distortion: " +
         list_text(Eigen::Map<const Eigen::VectorXd>(intrinsics.distortion.data(),
                                                     static_cast<Eigen::Index>(intrinsics.distortion.size()))) +
         "}";
}

// Intrinsics are part of a result where they were to be found, too.
std::string refined_yaml(const SensorResult& sensor, const CalibrationResult& result) {
  for (const CameraEvidence& camera : result.cameras) {
    if (camera.name != sensor.name || !camera.refined_intrinsics || !sensor.T_base_sensor) continue;
    return "    intrinsics: " + intrinsics_text(camera.estimate.intrinsics) + "\n";
  }
  return {};
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
    const std::string stamp =
        times ? tum_stamp(stop.start_ns + (stop.end_ns - stop.start_ns) / 2) : std::to_string(stop.index);
    text += tum_line(stamp, pose.T_G_base);
  }
  return text;
}

}  // namespace rigcal
