// Where the sensors are, in every form that somebody may want to copy.
#include <cmath>

#include "core/base/text.h"
#include "core/quality/lidar_quality.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/rpy.h"

namespace rigcal::html {
namespace {

std::string triple(const Vector3d& v, int digits) {
  return fixed_text(v.x(), digits) + ", " + fixed_text(v.y(), digits) + ", " + fixed_text(v.z(), digits);
}

Vector3d sigma_mm(const SensorResult& sensor) { return 1e3 * sensor.covariance.diagonal().tail<3>().cwiseSqrt(); }
Vector3d sigma_deg(const SensorResult& sensor) {
  return sensor.covariance.diagonal().head<3>().cwiseSqrt() * (180.0 / pi);
}

std::string matrix(const SE3& T) {
  std::string out;
  for (int row = 0; row < 4; ++row) {
    out += "[";
    for (int column = 0; column < 4; ++column) {
      const std::string number = fixed_text(T.matrix()(row, column), 9);
      out += (column == 0 ? "" : ", ") + std::string(number.size() < 13 ? 13 - number.size() : 0, ' ') + number;
    }
    out += row == 3 ? "]" : "],\n";
  }
  return out;
}

std::string moved(const SensorResult& sensor) {
  if (!sensor.guess_T_base_sensor) return "no guess";
  const SE3 move = sensor.guess_T_base_sensor->inverse() * *sensor.T_base_sensor;
  return fixed_text(1e3 * move.t.norm(), 1) + " mm, " + fixed_text(to_deg(log_so3(move.R).norm()), 2) + "°";
}

std::string details(const CalibrationResult& result, const SensorResult& sensor) {
  const SE3& T = *sensor.T_base_sensor;
  const Eigen::Vector4d q = xyzw_from_rotation(T.R);
  const Vector3d p = T * Vector3d(1.0, 0.0, 0.0);
  const std::string name = html_text(sensor.name);
  const std::string base = html_text(result.base);
  std::string out = "<details><summary>" + name + " in all forms</summary>";
  out +=
      table({"", "value"}, {{"translation, m", "[" + triple(T.t, 6) + "]"},
                            {"rotation [x, y, z, w]", "[" + fixed_text(q[0], 9) + ", " + fixed_text(q[1], 9) + ", " +
                                                          fixed_text(q[2], 9) + ", " + fixed_text(q[3], 9) + "]"},
                            {"roll, pitch, yaw, degrees", triple(rpy_from_rotation(T.R) * (180.0 / pi), 5)},
                            {"95 % bounds", fixed_text(1e3 * translation_bound(sensor.covariance), 2) + " mm, " +
                                                fixed_text(to_deg(rotation_bound(sensor.covariance)), 4) + " degrees"},
                            {"a worked point", "p_sensor = [1, 0, 0] is p_base = [" + triple(p, 6) + "]"}});
  out += "<h4>T: " + name + " into " + base + "</h4><pre>" + matrix(T) + "</pre>";
  out += "<h4>Its inverse: " + base + " into " + name + "</h4><pre>" + matrix(T.inverse()) + "</pre>";
  return out + "</details>";
}

std::string weak_table(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows;
  for (const SensorResult& sensor : result.sensors) {
    for (const WeakDirection& weak : sensor.weak_directions) {
      const std::string bound =
          weak.is_turn ? fixed_text(to_deg(weak.bound), 3) + "°" : fixed_text(1e3 * weak.bound, 1) + " mm";
      rows.push_back(
          {sensor.name, std::string(weak.is_turn ? "turn about " : "place along ") + direction_words(weak.axis),
           weak.is_open ? "open: no transform" : bound + (weak.is_frozen ? ", not fitted" : ""), weak.missing});
    }
  }
  if (rows.empty()) return {};
  return table({"sensor", "weak direction", "known to (95 %)", "what would hold it"}, rows);
}

// Beside the 2 cm that Livox' data sheets promise, which others come to as well.
std::string noise_table(const CalibrationResult& result) {
  constexpr double usual_range_m = 10.0;
  std::vector<std::vector<std::string>> rows;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.noise) continue;
    const double range_m = std::sqrt(sensor.noise->range_variance(usual_range_m * usual_range_m, 1.0));
    rows.push_back({sensor.name, fixed_text(1e3 * range_m, 1), fixed_text(1e3 * NoiseModel{}.range_m, 1),
                    fixed_text(to_deg(sensor.noise->angle_rad), 3),
                    sensor.grid_shift ? fixed_text(1e3 * sensor.grid_shift->translation_m, 2) + " mm, " +
                                            fixed_text(to_deg(sensor.grid_shift->rotation_rad), 4) + "°"
                                      : "–"});
  }
  if (rows.empty()) return {};
  return table({"LiDAR", "noise of ranges at 10 m, mm", "Livox' data sheets, mm", "of directions, °",
                "hangs on the voxels' grid by"},
               rows);
}

// Of what noise does not explain.
constexpr const char* what_is_left =
    "Sigma and bounds are of noise, and of what shows in the data: errors of ranges, uneven surfaces, stops that "
    "differ. "
    "What all stops share and no other sensor contradicts is in the result and not in them: a beam that is not where "
    "its "
    "unit says, intrinsics that are off, a rig that bends. Of real sensors a few millimetres may remain whatever "
    "stands "
    "here; a second recording in another place, or after a remount, shows them.";

}  // namespace

std::string numbers_part(const CalibrationResult& result) {
  std::vector<std::vector<std::string>> rows;
  std::string all;
  for (const SensorResult& sensor : result.sensors) {
    if (!sensor.T_base_sensor || sensor.name == result.base) continue;
    rows.push_back({sensor.name, triple(sensor.T_base_sensor->t, 4),
                    triple(rpy_from_rotation(sensor.T_base_sensor->R) * (180.0 / pi), 3), triple(sigma_mm(sensor), 2),
                    triple(sigma_deg(sensor), 4), moved(sensor)});
    all += details(result, sensor);
  }
  if (rows.empty()) return section("numbers", "Numbers", paragraph("No sensor has a transform.") + weak_table(result));
  const std::string remark =
      "<b>p_base = R p_sensor + t.</b> The table holds T_base_sensor, which maps coordinates in the sensor into " +
      html_text(result.base) +
      ". Rotation is Rz(yaw) Ry(pitch) Rx(roll). Sigma (1 standard deviation) is along the sensor's own axes x, y, z. "
      "<code>extrinsics.yaml</code> beside this page has all digits; <code>rigcal export</code> writes them for ROS 2, "
      "URDF, Autoware, Kalibr, OpenCV and COLMAP.";
  return section("numbers", "Numbers",
                 table({"sensor", "x, y, z, m", "roll, pitch, yaw, °", "sigma, mm", "sigma, °", "moved from the guess"},
                       rows, remark) +
                     paragraph(what_is_left) + weak_table(result) + noise_table(result) + all);
}

}  // namespace rigcal::html
