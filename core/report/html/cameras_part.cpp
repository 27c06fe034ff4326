// What the cameras' images say: the LiDARs' edges drawn into them, and the figures that the verdict rests on.
#include <algorithm>

#include "core/base/text.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"

namespace rigcal::html {
namespace {

std::string pictures_of(const CalibrationResult& result) {
  std::string out;
  for (const Overlay& overlay : result.overlays) {
    const auto stop = static_cast<std::size_t>(std::max(overlay.stop, 0));
    const std::string number =
        stop < result.trajectory.size() ? std::to_string(result.trajectory[stop].stop.index) : "?";
    const std::string name = html_text(overlay.sensor) + ", stop " + number;
    const std::string words = overlay.kind == OverlayKind::edges
                                  ? "edges that the LiDARs saw, orange at the guess, blue at the result. Blue must lie "
                                    "on the edges of the image."
                                  : "the LiDARs' map, coloured by range. Its steps must lie on those of the image.";
    out += figure("<img alt=\"" + name + "\" src=\"data:image/jpeg;base64," + base64(overlay.jpeg) + "\">",
                  "<b>" + name + ":</b> " + words);
  }
  return out.empty() ? out : "<div class=\"pairs\">" + out + "</div>";
}

std::string with_sigma(const ScalarEstimate& estimate, double unit, int digits) {
  return fixed_text(unit * estimate.value, digits) + " ± " + fixed_text(unit * estimate.sigma, digits);
}

std::string second_opinion(const CameraEstimate& estimate) {
  if (!estimate.information) return "none";
  const SE3 apart = estimate.pose.T_base_camera.inverse() * estimate.information->T_base_camera;
  return fixed_text(1e3 * apart.t.norm(), 1) + " mm, " + fixed_text(to_deg(log_so3(apart.R).norm()), 3) + "° (chi² " +
         fixed_text(estimate.disagreement_chi2, 1) + ")";
}

std::string figures_of(const CalibrationResult& result) {
  if (result.method == "checkerboard") return {};  // neither edges nor reflectivity were asked
  std::vector<std::vector<std::string>> rows;
  std::vector<std::vector<std::string>> intrinsics;
  for (const CameraEvidence& camera : result.cameras) {
    const CameraEstimate& e = camera.estimate;
    const std::string images = std::to_string(e.views_with_edges) + " of " + std::to_string(camera.images.size());
    if (!e.found) {
      rows.push_back({camera.name, images, "not found", "–", "–", "–", "–"});
      continue;
    }
    rows.push_back({camera.name, images, std::to_string(e.edge_points), fixed_text(e.residual_px, 2), second_opinion(e),
                    fixed_text(1e3 * e.halves_m, 1) + " mm, " + fixed_text(to_deg(e.halves_rad), 3) + "°",
                    e.runner_up ? fixed_text(e.runner_up_ratio, 2) : "none met"});
    if (e.focal_scale.sigma == 0.0) {
      intrinsics.push_back({camera.name, "too few stops to tell", "–", "–", "–", "as given"});
      continue;
    }
    intrinsics.push_back({camera.name, with_sigma(e.focal_scale, 1e2, 3) + " %", with_sigma(e.k1_change, 1.0, 4),
                          with_sigma(e.cx_change_px, 1.0, 2) + " and " + with_sigma(e.cy_change_px, 1.0, 2) + " px",
                          with_sigma(e.radial_trend, 1.0, 2) + " px",
                          camera.refined_intrinsics ? "found here" : "as given"});
  }
  if (rows.empty()) return {};
  std::string out = table(
      {"camera", "images used", "edge points matched", "residual, px", "second opinion apart", "halves apart",
       "runner-up"},
      rows,
      "The second opinion is the pose at which reflectivity and grey values tell most about each other. Halves: "
      "poses from either half of the stops. The runner-up is the best other pose, as a share of the winner's score.");
  if (intrinsics.empty()) return out;
  return out + table({"camera", "focal length off by", "k1 off by", "principal point off by (cx and cy)",
                      "radial trend at the corner", "intrinsics"},
                     intrinsics,
                     "How far the rig file's intrinsics seem to be off. More than three times the number behind ± is "
                     "more than chance.");
}

}  // namespace

std::string cameras_part(const CalibrationResult& result) {
  return section("cameras", "What the cameras see", pictures_of(result) + figures_of(result));
}

}  // namespace rigcal::html
