// Formats of camera tools, and matrices for OpenCV.
#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/text.h"
#include "core/report/matrix_text.h"
#include "core/report/result_writers.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Eigen::VectorXd vector_of(const std::vector<double>& values) {
  return Eigen::Map<const Eigen::VectorXd>(values.data(), static_cast<Eigen::Index>(values.size()));
}

/// radtan's k3, which not every tool has.
double third_radial(const CameraIntrinsics& camera) {
  return camera.model == DistortionModel::radtan && camera.distortion.size() == 5 ? camera.distortion[4] : 0.0;
}

std::string kalibr_camera(const PlacedSensor& sensor, std::vector<std::string>& warnings) {
  if (sensor.intrinsics == nullptr) {
    warnings.push_back(
        sensor.name +
        " is known without intrinsics, and Kalibr reads no camera without them: give --rig RIG with them");
    return {};
  }
  const CameraIntrinsics& camera = *sensor.intrinsics;
  if (third_radial(camera) != 0.0) {
    warnings.push_back(sensor.name + ": Kalibr's radtan has no k3, so that " + number_text(third_radial(camera)) +
                       " is lost");
  }
  if (sensor.topic.empty())
    warnings.push_back(sensor.name +
                       " is known without a topic, and Kalibr's own tools want its rostopic: give --rig RIG with it");
  const std::size_t kept = std::min<std::size_t>(camera.distortion.size(), 4);
  const Eigen::Vector4d pinhole(camera.fx, camera.fy, camera.cx, camera.cy);
  return "  camera_model: pinhole\n  intrinsics: " + list_text(pinhole) +
         "\n  distortion_model: " + (camera.model == DistortionModel::radtan ? "radtan" : "equidistant") +
         "\n  distortion_coeffs: " + list_text(vector_of(camera.distortion).head(static_cast<Eigen::Index>(kept))) +
         "\n  resolution: [" + std::to_string(camera.width) + ", " + std::to_string(camera.height) + "]\n" +
         (sensor.topic.empty() ? "" : "  rostopic: " + quoted_text(sensor.topic) + "\n");
}

/// COLMAP counts pixels from the corner of the first one, not from its centre.
constexpr double colmap_pixel_shift = 0.5;

void add_colmap_camera(const CameraIntrinsics& camera, Json& json) {
  std::vector<double> parameters{camera.fx, camera.fy, camera.cx + colmap_pixel_shift, camera.cy + colmap_pixel_shift};
  const std::size_t kept = std::min<std::size_t>(camera.distortion.size(), 4);
  parameters.insert(parameters.end(), camera.distortion.begin(),
                    camera.distortion.begin() + static_cast<std::ptrdiff_t>(kept));
  parameters.resize(8, 0.0);
  std::string model = camera.model == DistortionModel::radtan ? "OPENCV" : "OPENCV_FISHEYE";
  if (third_radial(camera) != 0.0) {
    model = "FULL_OPENCV";
    parameters.insert(parameters.end(), {third_radial(camera), 0.0, 0.0, 0.0});
  }
  json["camera_model_name"] = model;
  json["camera_params"] = parameters;
}

std::string opencv_matrix(const std::string& name, const Eigen::Ref<const Eigen::MatrixXd>& matrix) {
  std::string text = "      " + name + ": !!opencv-matrix\n         rows: " + std::to_string(matrix.rows()) +
                     "\n         cols: " + std::to_string(matrix.cols()) + "\n         dt: d\n         data: ";
  Eigen::VectorXd values(matrix.size());
  for (Eigen::Index i = 0; i < matrix.size(); ++i) values[i] = matrix(i / matrix.cols(), i % matrix.cols());
  return text + list_text(values) + "\n";
}

}  // namespace

std::string kalibr_yaml(const PlacedRig& rig, std::vector<std::string>& warnings) {
  const bool cameras = !rig.sensors.empty() && rig.sensors.front().is_camera;
  const std::string kind = cameras ? "cam" : "lidar";
  std::string text = "# T_a_b maps coordinates of b into a; T_cn_cnm1: from the sensor before into this one.\n";
  if (!cameras) text += "# LiDARs in the layout of a chain of cameras; Kalibr itself reads cameras only.\n";
  for (std::size_t i = 0; i < rig.sensors.size(); ++i) {
    const PlacedSensor& sensor = rig.sensors[i];
    const SE3 T_sensor_base = sensor.T_base_sensor.inverse();
    text += kind + std::to_string(i) + ":\n  name: " + key_text(sensor.name) + "\n";
    if (cameras) text += kalibr_camera(sensor, warnings);
    if (i > 0) {
      text += "  T_cn_cnm1: " + matrix_text((T_sensor_base * rig.sensors[i - 1].T_base_sensor).matrix()) + "\n";
    }
    text += "  T_" + kind + "_base: " + matrix_text(T_sensor_base.matrix()) + "\n";
  }
  return text;
}

std::string colmap_json(const PlacedRig& rig) {
  Json cameras = Json::array();
  const auto base = std::find_if(rig.sensors.begin(), rig.sensors.end(),
                                 [&rig](const PlacedSensor& sensor) { return sensor.name == rig.base; });
  const auto reference = base == rig.sensors.end() ? rig.sensors.begin() : base;
  for (auto sensor = rig.sensors.begin(); sensor != rig.sensors.end(); ++sensor) {
    Json camera{{"image_prefix", sensor->name + "/"}};
    if (sensor == reference) {
      camera["ref_sensor"] = true;
    } else {
      const SE3 T = sensor->T_base_sensor.inverse() * reference->T_base_sensor;
      const Eigen::Vector4d q = xyzw_from_rotation(T.R);
      camera["cam_from_rig_rotation"] = {q[3], q[0], q[1], q[2]};
      camera["cam_from_rig_translation"] = {T.t.x(), T.t.y(), T.t.z()};
    }
    if (sensor->intrinsics != nullptr) add_colmap_camera(*sensor->intrinsics, camera);
    cameras.push_back(std::move(camera));
  }
  return Json::array({Json{{"cameras", cameras}}}).dump(2) + "\n";
}

std::string opencv_yaml(const PlacedRig& rig) {
  std::string text = "%YAML:1.0\n---\nbase: " + quoted_text(rig.base) + "\nsensors:\n";
  for (const PlacedSensor& sensor : rig.sensors) {
    text += "   -\n      name: " + quoted_text(sensor.name) + "\n";
    text += opencv_matrix("T_base_sensor", sensor.T_base_sensor.matrix());
    if (sensor.intrinsics == nullptr) continue;
    const CameraIntrinsics& camera = *sensor.intrinsics;
    Matrix3d K;
    K << camera.fx, 0.0, camera.cx, 0.0, camera.fy, camera.cy, 0.0, 0.0, 1.0;
    text += "      image_width: " + std::to_string(camera.width) +
            "\n      image_height: " + std::to_string(camera.height) + "\n";
    text += opencv_matrix("camera_matrix", K);
    text += std::string("      distortion_model: ") +
            (camera.model == DistortionModel::radtan ? "\"radtan\"" : "\"equidistant\"") + "\n";
    text += opencv_matrix("distortion_coefficients", vector_of(camera.distortion).transpose());
  }
  return text;
}

}  // namespace rigcal
