#include "apps/calibration/estimate_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/base/text.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

Json vector_json(const Vector3d& v) { return {v.x(), v.y(), v.z()}; }

Json bounds_json(const PredictedBounds& bounds, const StopEstimate& estimate) {
  // The advice counts LiDARs, which are what an estimate lists.
  return {{"sensor", estimate.lidars[static_cast<std::size_t>(bounds.lidar)].result.name},
          {"translation_bound_mm", 1e3 * bounds.translation_m},
          {"rotation_bound_deg", to_deg(bounds.rotation_rad)},
          {"of_goal", bounds.of_goal}};
}

Json advice_json(const StopEstimate& estimate) {
  if (!estimate.advice) return nullptr;
  const StopAdvice& advice = *estimate.advice;
  Json turns = Json::array();
  for (const TurnCandidate& turn : advice.turns) {
    Json one{{"turn_deg", to_deg(turn.angle_rad)}};
    one.update(bounds_json(turn.after, estimate));
    turns.push_back(std::move(one));
  }
  Json json{{"text", estimate.advice_text},
            {"now", bounds_json(advice.now, estimate)},
            {"best_turn_deg", to_deg(advice.turns[advice.best_turn].angle_rad)},
            {"turns", std::move(turns)},
            {"surface", nullptr}};
  if (advice.surface) {
    json["surface"] = {{"place", vector_json(advice.surface->place)},
                       {"normal", vector_json(advice.surface->normal)},
                       {"after", bounds_json(advice.surface->after, estimate)}};
  }
  return json;
}

Json lidar_json(const LidarEstimate& lidar) {
  Json json{{"sensor", lidar.result.name},
            {"status", to_string(lidar.result.status)},
            {"reasons", lidar.result.reasons},
            {"translation_bound_mm", 1e3 * lidar.translation_bound_m},
            {"rotation_bound_deg", to_deg(lidar.rotation_bound_rad)}};
  if (!lidar.result.T_base_sensor) return json;
  const Eigen::Vector4d q = xyzw_from_rotation(lidar.result.T_base_sensor->R);
  json["translation"] = vector_json(lidar.result.T_base_sensor->t);
  json["rotation_xyzw"] = {q[0], q[1], q[2], q[3]};
  if (lidar.translation_bound_m == 0.0) return json;
  json["weak_translation"] = vector_json(lidar.weak_translation);
  json["weak_rotation"] = vector_json(lidar.weak_rotation);
  return json;
}

}  // namespace

std::string estimate_line(const StopEstimate& estimate) {
  std::string text = counted(estimate.stops, "stop") + ":";
  for (const LidarEstimate& lidar : estimate.lidars) {
    if (lidar.result.T_base_sensor && lidar.translation_bound_m == 0.0) continue;  // the base
    if (lidar.result.T_base_sensor) {
      text += fmt::format(" {} {} {:.1f} mm {:.3f} deg;", lidar.result.name, to_string(lidar.result.status),
                          1e3 * lidar.translation_bound_m, to_deg(lidar.rotation_bound_rad));
    } else {
      text += fmt::format(" {} {};", lidar.result.name, to_string(lidar.result.status));
    }
  }
  text.back() = ',';
  return text + fmt::format(" {:.1f} s{}", estimate.wall_s, estimate.reached ? ", the goal is reached" : "");
}

std::vector<std::string> estimate_remarks(const StopEstimate& estimate) {
  std::vector<std::string> lines = estimate.warnings;
  for (const LidarEstimate& lidar : estimate.lidars) {
    for (const std::string& reason : lidar.result.reasons) lines.push_back(lidar.result.name + ": " + reason);
  }
  if (!estimate.advice_text.empty() && !estimate.reached) lines.push_back(estimate.advice_text);
  return lines;
}

std::vector<std::string> estimate_block(const StopEstimate& estimate) {
  constexpr std::size_t width = 77;
  std::vector<std::string> lines;
  for (const LidarEstimate& lidar : estimate.lidars) {
    if (lidar.result.T_base_sensor && lidar.translation_bound_m == 0.0) continue;  // the base
    std::string bounds = "not known yet";
    if (lidar.result.T_base_sensor) {
      bounds = fmt::format("{:6.1f} mm {:7.3f} deg (95 %)", 1e3 * lidar.translation_bound_m,
                           to_deg(lidar.rotation_bound_rad));
    }
    lines.push_back(fmt::format("  {:<16} {:<6} {}", lidar.result.name, to_string(lidar.result.status), bounds));
  }
  if (estimate.reached) lines.emplace_back("  the goal is reached");
  std::string rest = estimate.reached ? std::string() : estimate.advice_text;
  while (!rest.empty()) {
    std::size_t cut = rest.size();
    if (cut > width) {
      cut = rest.rfind(' ', width);
      if (cut == std::string::npos) cut = width;
    }
    lines.push_back("  " + rest.substr(0, cut));
    rest.erase(0, std::min(rest.size(), cut + 1));
  }
  return lines;
}

Json estimates_json(std::span<const StopEstimate> estimates) {
  Json json = Json::array();
  for (const StopEstimate& estimate : estimates) {
    Json lidars = Json::array();
    for (const LidarEstimate& lidar : estimate.lidars) lidars.push_back(lidar_json(lidar));
    json.push_back({{"stops", estimate.stops},
                    {"reached", estimate.reached},
                    {"searched", estimate.searched},
                    {"warnings", estimate.warnings},
                    {"wall_s", estimate.wall_s},
                    {"lidars", std::move(lidars)},
                    {"advice", advice_json(estimate)}});
  }
  return json;
}

}  // namespace rigcal
