// The map to turn with the mouse: points, sensors with their fields of view, the way of the rig.
#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/base/median.h"
#include "core/report/html/field_of_view.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/palette.h"

namespace rigcal::html {
namespace {

using Json = nlohmann::ordered_json;

// 10 bytes each, 4 MB as text: enough to recognise a scene.
constexpr std::size_t most_points = 300'000;
constexpr double largest_step = 32767.0;

struct Box {
  Vector3d center = Vector3d::Zero();
  double half_m = 1.0;
};

// Holds all but the farthest points: one stray return must not make the rest a dot.
Box box_of(const std::vector<const MapPoint*>& points) {
  Box box;
  box.half_m = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values;
    values.reserve(points.size());
    for (const MapPoint* p : points) values.push_back(axis == 0 ? p->x : axis == 1 ? p->y : p->z);
    const double low = quantile(values, 0.005);
    const double high = quantile(values, 0.995);
    box.center[axis] = 0.5 * (low + high);
    box.half_m = std::max(box.half_m, 0.55 * (high - low));
  }
  box.half_m = std::max(box.half_m, 1.0);
  return box;
}

std::vector<const MapPoint*> chosen_points(const std::vector<MapPoint>& map) {
  std::vector<const MapPoint*> out;
  const std::size_t kept = std::min(map.size(), most_points);
  for (std::size_t k = 0; k < kept; ++k) {
    const MapPoint& p = map[k * map.size() / kept];
    if (std::isfinite(p.x + p.y + p.z)) out.push_back(&p);
  }
  return out;
}

// Three int16 of the place in the box, little-endian, then red, green, blue and the sensor.
// Points that no camera saw, and all where there is none, are as grey as they reflect.
std::vector<std::uint8_t> packed(const CalibrationResult& result, const std::vector<const MapPoint*>& points,
                                 const Box& box) {
  std::vector<std::uint8_t> out;
  out.reserve(10 * points.size());
  for (const MapPoint* p : points) {
    const Vector3d share = (Vector3d(p->x, p->y, p->z) - box.center) / box.half_m;
    if (share.cwiseAbs().maxCoeff() > 1.0) continue;
    for (const double s : share) {
      const auto step = static_cast<std::uint16_t>(static_cast<std::int16_t>(std::lround(s * largest_step)));
      out.push_back(static_cast<std::uint8_t>(step & 0xFFU));
      out.push_back(static_cast<std::uint8_t>(step >> 8U));
    }
    if (result.map_rgb.size() == result.map.size()) {
      const auto& rgb = result.map_rgb[static_cast<std::size_t>(p - result.map.data())];
      out.insert(out.end(), rgb.begin(), rgb.end());
    } else {
      out.insert(out.end(), 3, p->reflectivity);
    }
    out.push_back(p->sensor);
  }
  return out;
}

Json vector_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json sensor_json(const SensorResult& sensor, std::size_t index, const Rig* rig) {
  Json json{{"name", sensor.name}, {"colour", series_colour(index)}, {"T", Json::array()}, {"view", Json::array()}};
  const Eigen::Matrix4d T = sensor.T_base_sensor->matrix();
  for (int k = 0; k < 16; ++k) json["T"].push_back(T(k % 4, k / 4));
  const int in_rig = rig == nullptr ? -1 : rig->find(sensor.name);
  if (in_rig < 0) return json;
  for (const Vector3d& ray : field_of_view(rig->sensors[static_cast<std::size_t>(in_rig)])) {
    json["view"].push_back(vector_json(ray));
  }
  return json;
}

// Text in a script element ends at "</", whatever it is in.
std::string script_text(const Json& json) {
  std::string text = json.dump(-1, ' ', true, Json::error_handler_t::replace);
  for (std::size_t at = text.find('<'); at != std::string::npos; at = text.find('<', at))
    text.replace(at, 1, "\\u003c");
  return text;
}

}  // namespace

std::string view_part(const CalibrationResult& result, const Rig* rig) {
  const std::vector<const MapPoint*> points = chosen_points(result.map);
  if (points.empty()) return {};
  const Box box = box_of(points);
  Json scene{{"center", vector_json(box.center)}, {"half", box.half_m}, {"palette", series_rgb}};
  scene["sensors"] = Json::array();
  std::vector<char> shown(result.sensors.size(), 0);
  for (std::size_t i = 0; i < result.sensors.size(); ++i) {
    if (!result.sensors[i].T_base_sensor) continue;
    scene["sensors"].push_back(sensor_json(result.sensors[i], i, rig));
    shown[i] = 1;
  }
  scene["stops"] = Json::array();
  for (const StopPose& pose : result.trajectory) {
    if (pose.known) scene["stops"].push_back(vector_json(pose.T_G_base.t));
  }
  const std::vector<std::uint8_t> bytes = packed(result, points, box);
  std::string out =
      "<div class=\"buttons\" role=\"group\" aria-label=\"3-D view\"></div><div id=\"view3d\" "
      "tabindex=\"0\" aria-label=\"The map, to turn with the mouse\"><p class=\"no3d\">The 3-D view needs "
      "a browser with WebGL. The pictures below show the same map from above and from the side.</p></div>";
  out += paragraph("Drag to turn, two fingers or the right button to move, wheel to come nearer (after a click). " +
                   std::to_string(bytes.size() / 10) + " of " + std::to_string(result.map.size()) +
                   " points; <code>map.ply</code> has all. The rig stands at its first stop. " +
                   colour_key(result, shown));
  out += "<script type=\"application/json\" id=\"scene\">" + script_text(scene) + "</script>";
  out += "<script type=\"text/plain\" id=\"points\">" + base64(bytes) + "</script>";
  return section("map", "The map", out);
}

}  // namespace rigcal::html
