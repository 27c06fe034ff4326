#include "apps/commands/calibration_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "apps/calibration/estimate_text.h"
#include "apps/common/json_text.h"
#include "core/base/text.h"
#include "core/report/result_texts.h"
#include "core/report/summary_text.h"

namespace rigcal {

std::string calibration_text(const CalibrationResult& result, const std::string& out) {
  std::string text = fmt::format("{}: {}\nT_{}_sensor, p_{} = R p_sensor + t:\n", to_string(result.status),
                                 summary_sentence(result), result.base, result.base);
  for (const SensorResult& s : result.sensors) {
    if (s.name == result.base && s.reasons.empty()) continue;
    if (!s.T_base_sensor) {
      text += fmt::format("  {:<16} {}\n", s.name, to_string(s.status));
    } else {
      const Vector3d& t = s.T_base_sensor->t;
      const Eigen::Vector4d q = xyzw_from_rotation(s.T_base_sensor->R);
      const Vector3d mm = 1e3 * s.covariance.diagonal().tail<3>().cwiseSqrt();
      const Vector3d deg = s.covariance.diagonal().head<3>().cwiseSqrt() * (180.0 / pi);
      text += fmt::format(
          "  {:<16} {:<6} t [{:+.4f}, {:+.4f}, {:+.4f}] m, q_xyzw [{:+.6f}, {:+.6f}, {:+.6f}, {:+.6f}], sigma {:.2f} "
          "mm "
          "and {:.4f} deg on the worst axis\n",
          s.name, to_string(s.status), t.x(), t.y(), t.z(), q[0], q[1], q[2], q[3], mm.maxCoeff(), deg.maxCoeff());
    }
    for (const std::string& reason : s.reasons) text += fmt::format("    - {}\n", reason);
  }
  for (const SensorResult& s : result.sensors) {
    if (s.name == result.base || !s.T_base_sensor) continue;
    const bool is_camera = std::any_of(result.cameras.begin(), result.cameras.end(),
                                       [&](const CameraEvidence& camera) { return camera.name == s.name; });
    text += worked_point_text(s.name, is_camera, result.base, *s.T_base_sensor) + "\n";
    break;
  }
  double seconds = 0.0;
  for (const StageReport& stage : result.stages) seconds += stage.wall_s;
  text += fmt::format("{}, {:.1f} s; result in {}: open report.html in it\n", counted(result.trajectory.size(), "stop"),
                      seconds, out);
  return text;
}

std::string calibration_json(const CalibrationResult& result, const std::string& out,
                             const std::vector<StopEstimate>& estimates) {
  nlohmann::ordered_json json = nlohmann::ordered_json::parse(report_json(result));
  json["command"] = "calibrate";
  json["out"] = out;
  if (!estimates.empty()) json["estimates"] = estimates_json(estimates);
  return json_text(json);
}

}  // namespace rigcal
