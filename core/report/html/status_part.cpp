// What a reader must see first: is it good, and if not, which sensor and why.
#include <algorithm>

#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/summary_text.h"

namespace rigcal::html {
namespace {

constexpr std::size_t warnings_at_once = 4;

std::string type_of(const Rig* rig, const std::string& name) {
  const int index = rig == nullptr ? -1 : rig->find(name);
  if (index < 0) return {};
  const Sensor& sensor = rig->sensors[static_cast<std::size_t>(index)];
  return sensor.lidar ? to_string(sensor.lidar->model) : "camera";
}

std::string list_of(std::vector<std::string>::const_iterator begin, std::vector<std::string>::const_iterator end) {
  std::string out = "<ul>";
  for (; begin != end; ++begin) out += "<li>" + html_text(*begin) + "</li>";
  return out + "</ul>";
}

std::string card(const CalibrationResult& result, const SensorResult& sensor, const Rig* rig) {
  std::string out = std::string("<article class=\"card ") + to_string(sensor.status) + "\"><h3>" +
                    html_text(sensor.name) + "</h3>" + badge(sensor.status);
  const std::string type = type_of(rig, sensor.name);
  if (!type.empty()) out += "<span class=\"type\">" + html_text(type) + "</span>";
  out += paragraph(html_text(bounds_text(result, sensor)));
  if (!sensor.reasons.empty()) out += list_of(sensor.reasons.begin(), sensor.reasons.end());
  return out + "</article>";
}

// The worst first: they are what the page is opened for.
std::vector<const SensorResult*> worst_first(const CalibrationResult& result) {
  std::vector<const SensorResult*> out;
  for (const SensorResult& sensor : result.sensors) out.push_back(&sensor);
  std::stable_sort(out.begin(), out.end(),
                   [](const SensorResult* a, const SensorResult* b) { return a->status > b->status; });
  return out;
}

std::string warnings_of(const std::vector<std::string>& warnings) {
  if (warnings.empty()) return {};
  const auto split = warnings.begin() + static_cast<std::ptrdiff_t>(std::min(warnings.size(), warnings_at_once));
  std::string out = "<div class=\"warnings\"><h3>What happened on the way</h3>" + list_of(warnings.begin(), split);
  if (split != warnings.end()) {
    out += "<details><summary>" + std::to_string(warnings.end() - split) + " more</summary>" +
           list_of(split, warnings.end()) + "</details>";
  }
  return out + "</div>";
}

}  // namespace

std::string status_part(const CalibrationResult& result, const Rig* rig) {
  const auto solved = std::count_if(result.trajectory.begin(), result.trajectory.end(),
                                    [](const StopPose& stop) { return stop.known; });
  std::string out = std::string("<header class=\"") + to_string(result.status) + "\"><p class=\"what\">Calibration" +
                    (rig == nullptr || rig->name.empty() ? std::string() : " of " + html_text(rig->name)) + "</p><h1>" +
                    badge(result.status) + " " + html_text(summary_sentence(result)) + "</h1>";
  out += "<p class=\"what\">" + html_text(result.method) + ", base " + html_text(result.base) + ", " +
         std::to_string(solved) + " of " + std::to_string(result.trajectory.size()) + " stops used" +
         (result.warnings.empty() ? ""
                                  : ", " + std::to_string(result.warnings.size()) +
                                        (result.warnings.size() == 1 ? " warning" : " warnings")) +
         "</p></header>\n";
  std::string cards;
  for (const SensorResult* sensor : worst_first(result)) cards += card(result, *sensor, rig);
  return out + "<div class=\"cards\">" + cards + "</div>" + warnings_of(result.warnings) + "\n";
}

}  // namespace rigcal::html
