#include "apps/evaluation/evaluation_text.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "apps/common/json_text.h"
#include "core/base/version.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

// A number in a column of ten.
std::string column(double value, int decimals) {
  std::array<char, 64> text{};
  std::snprintf(text.data(), text.size(), "%10.*f", decimals, value);
  return text.data();
}

std::string padded(const std::string& text, std::size_t width) {
  return text.size() < width ? text + std::string(width - text.size(), ' ') : text;
}

const char* state_of(const SensorError& error) { return error.missing ? "missing" : to_string(error.status); }

std::string row(const SensorError& error, std::size_t name_width) {
  std::string text = padded(error.name, name_width) + "  " + padded(state_of(error), 7);
  if (!error.compared) return text + "  no transform to compare\n";
  text += column(to_deg(error.rotation_rad), 4) + column(error.translation_m * 1e3, 2) + " |";
  for (int i = 0; i < 3; ++i) text += column(to_deg(error.xi[i]), 4);
  text += " |";
  for (int i = 3; i < 6; ++i) text += column(error.xi[i] * 1e3, 2);
  text += " |" + (error.nees_per_dof ? column(*error.nees_per_dof, 2) : std::string("         -"));
  return text + "\n";
}

std::string poses_text(const PoseErrors& poses) {
  std::string text =
      "poses of " + std::to_string(poses.compared) + " stops: median" + column(to_deg(poses.median_rotation_rad), 4) +
      " deg" + column(poses.median_translation_m * 1e3, 2) + " mm, worst" +
      column(to_deg(poses.worst_rotation_rad), 4) + " deg" + column(poses.worst_translation_m * 1e3, 2) + " mm\n";
  if (poses.unmatched > 0) text += "stops of the truth without a pose: " + std::to_string(poses.unmatched) + "\n";
  return text;
}

Json axes_json(const Vector3d& values) { return {values.x(), values.y(), values.z()}; }

Json sensor_json(const SensorError& error) {
  Json json{{"name", error.name}, {"status", state_of(error)}};
  if (!error.compared) return json;
  json["rotation_error_deg"] = to_deg(error.rotation_rad);
  json["translation_error_mm"] = error.translation_m * 1e3;
  json["rotation_error_axes_deg"] = axes_json(error.xi.head<3>() * to_deg(1.0));
  json["translation_error_axes_mm"] = axes_json(error.xi.tail<3>() * 1e3);
  if (error.nees_per_dof) json["nees_per_dof"] = *error.nees_per_dof;
  return json;
}

}  // namespace

std::string evaluation_text(const Evaluation& evaluation) {
  std::size_t width = 6;
  for (const SensorError& error : evaluation.sensors) width = std::max(width, error.name.size());
  std::string text = "errors of T_base_sensor, base " + evaluation.base + "; axes are the sensor's own\n";
  text += padded("", width) + "             rotation     shift |         rotation x, y, z [deg] |" +
          "           shift x, y, z [mm] |    NEES\n";
  text += padded("sensor", width) + "  status        [deg]      [mm] |" + std::string(32, ' ') + "|" +
          std::string(31, ' ') + "|  per dof\n";
  for (const SensorError& error : evaluation.sensors) text += row(error, width);
  for (const std::string& name : evaluation.not_in_truth) text += padded(name, width) + "  is not in the truth\n";
  if (evaluation.poses) text += poses_text(*evaluation.poses);
  return text;
}

std::string evaluation_json(const Evaluation& evaluation, std::optional<bool> within) {
  Json json{{"rigcal", format_version}, {"command", "evaluate"}, {"base", evaluation.base}};
  json["sensors"] = Json::array();
  for (const SensorError& error : evaluation.sensors) json["sensors"].push_back(sensor_json(error));
  json["not_in_truth"] = evaluation.not_in_truth;
  if (evaluation.poses) {
    const PoseErrors& poses = *evaluation.poses;
    json["poses"] = {{"compared", poses.compared},
                     {"unmatched", poses.unmatched},
                     {"median_rotation_deg", to_deg(poses.median_rotation_rad)},
                     {"median_translation_mm", poses.median_translation_m * 1e3},
                     {"worst_rotation_deg", to_deg(poses.worst_rotation_rad)},
                     {"worst_translation_mm", poses.worst_translation_m * 1e3}};
  }
  if (within) json["within_max_error"] = *within;
  return json_text(json);
}

}  // namespace rigcal
