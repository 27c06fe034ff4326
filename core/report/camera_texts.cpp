#include "core/report/camera_texts.h"

#include <Eigen/Core>
#include <nlohmann/json.hpp>

#include "core/base/text.h"
#include "core/report/matrix_text.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

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
            {"radial_trend_px", scalar(e.radial_trend)},
            {"halves", {{"mm", 1e3 * e.halves_m}, {"deg", to_deg(e.halves_rad)}, {"chi2", e.halves_chi2}}}};
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

}  // namespace

std::string cameras_json(const CalibrationResult& result) {
  Json list = Json::array();
  for (const CameraEvidence& camera : result.cameras) {
    Json json{{"name", camera.name}, {"images", Json::array()}};
    for (const UsedImage& image : camera.images) {
      json["images"].push_back(
          {{"stop", result.trajectory[static_cast<std::size_t>(image.stop)].stop.index}, {"file", image.file}});
    }
    json["found"] = camera.estimate.found;
    json["wall_s"] = camera.estimate.wall_s;
    json["iterations"] = camera.estimate.iterations;
    if (camera.estimate.found) json.update(found_json(camera));
    list.push_back(json);
  }
  return list.dump(-1, ' ', false, Json::error_handler_t::replace);
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

}  // namespace rigcal
