// What a reader must see first: is it good, and if not, which sensor and why.
#include <algorithm>
#include <map>

#include "core/base/text.h"
#include "core/quality/recording_faults.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/summary_text.h"

namespace rigcal::html {
namespace {

constexpr std::size_t warnings_at_once = 4;

using FaultsBySensor = std::map<std::string, std::vector<std::string>>;

FaultsBySensor by_sensor(const std::vector<RecordingFault>& faults) {
  FaultsBySensor out;
  for (const RecordingFault& fault : faults) out[fault.sensor].push_back(fault.what);
  return out;
}

std::string type_of(const Rig* rig, const std::string& name) {
  const int index = rig == nullptr ? -1 : rig->find(name);
  if (index < 0) return {};
  const Sensor& sensor = rig->sensors[static_cast<std::size_t>(index)];
  return sensor.lidar ? facts_of(sensor.lidar->model).word : "camera";
}

std::string list_of(std::vector<std::string>::const_iterator begin, std::vector<std::string>::const_iterator end) {
  std::string out = "<ul>";
  for (; begin != end; ++begin) out += "<li>" + html_text(*begin) + "</li>";
  return out + "</ul>";
}

std::string card(const CalibrationResult& result, const SensorResult& sensor, const Rig* rig,
                 const FaultsBySensor& faults) {
  const auto fault = faults.find(sensor.name);
  const bool faulty = fault != faults.end();
  std::string out = std::string("<article class=\"card ") + to_string(sensor.status) + (faulty ? " faulty" : "") +
                    "\"><div class=\"who\"><h3>" + html_text(sensor.name) + "</h3>" + badge(sensor.status);
  const std::string type = type_of(rig, sensor.name);
  if (!type.empty()) out += "<span class=\"type\">" + html_text(type) + "</span>";
  out += "</div>" + paragraph(html_text(bounds_text(result, sensor)));
  if (!sensor.reasons.empty()) out += list_of(sensor.reasons.begin(), sensor.reasons.end());
  if (faulty) {
    out += "<p class=\"fault\">Its recording:</p>" + list_of(fault->second.begin(), fault->second.end());
  }
  return out + "</article>";
}

// The worst first: they are what the page is opened for. Then those whose recording has faults.
std::vector<const SensorResult*> worst_first(const CalibrationResult& result, const FaultsBySensor& faults) {
  std::vector<const SensorResult*> out;
  for (const SensorResult& sensor : result.sensors) out.push_back(&sensor);
  std::stable_sort(out.begin(), out.end(), [&](const SensorResult* a, const SensorResult* b) {
    if (a->status != b->status) return a->status > b->status;
    return faults.count(a->name) > faults.count(b->name);
  });
  return out;
}

std::string cards(const std::string& content) {
  return content.empty() ? content : "<div class=\"cards\">" + content + "</div>";
}

// What no card says.
std::string warnings_of(std::vector<std::string> warnings, const std::vector<RecordingFault>& faults) {
  for (const RecordingFault& fault : faults) std::erase(warnings, to_string(fault));
  if (warnings.empty()) return {};
  const auto split = warnings.cbegin() + static_cast<std::ptrdiff_t>(std::min(warnings.size(), warnings_at_once));
  std::string out = "<div class=\"warnings\"><h3>What happened on the way</h3>" + list_of(warnings.cbegin(), split);
  if (split != warnings.cend()) {
    out += "<details><summary>" + std::to_string(warnings.cend() - split) + " more</summary>" +
           list_of(split, warnings.cend()) + "</details>";
  }
  return out + "</div>";
}

std::string faults_sentence(Status status, const std::vector<RecordingFault>& faults) {
  const std::string brief = faults_in_brief(faults);
  const char* begin = status == Status::good ? "But the recording has faults: " : "The recording has faults, too: ";
  return brief.empty() ? brief : std::string("<p class=\"but\">") + begin + html_text(brief) + ".</p>";
}

std::string fact(const std::string& number, const std::string& what) {
  return "<div><dt>" + what + "</dt><dd>" + number + "</dd></div>";
}

// 7, 885 k, 2.1 M
std::string about(std::uint64_t points) {
  if (points < 10'000) return std::to_string(points);
  if (points < 1'000'000) return std::to_string((points + 500) / 1000) + " k";
  return fixed_text(1e-6 * static_cast<double>(points), 1) + " M";
}

// How large the run was and what came of it, in a line of figures.
std::string facts(const CalibrationResult& result) {
  const auto used = std::count_if(result.trajectory.begin(), result.trajectory.end(),
                                  [](const StopPose& stop) { return stop.is_used(); });
  std::uint64_t points = 0;
  for (const StopPose& stop : result.trajectory) {
    for (const auto& [sensor, count] : stop.points) points += count;
  }
  std::size_t images = 0;
  for (const CameraEvidence& camera : result.cameras) images += camera.images.size();
  double seconds = 0.0;
  for (const StageReport& stage : result.stages) seconds += stage.wall_s;
  std::string out = fact(std::to_string(used) + " of " + std::to_string(result.trajectory.size()), "stops used");
  if (points > 0) out += fact(about(points), "points");
  if (images > 0) out += fact(std::to_string(images), "images");
  if (!result.shared_surfaces.empty()) {
    const SharedSurfaces& all = result.shared_surfaces.back();
    out += fact(
        fixed_text(1e3 * all.before_m, all.before_m < 0.01 ? 1 : 0) + " → " + fixed_text(1e3 * all.after_m, 1) + " mm",
        "thickness of shared walls");
  }
  if (seconds > 0.0) out += fact(fixed_text(seconds, seconds < 10.0 ? 1 : 0) + " s", "computing time");
  return "<dl class=\"facts\">" + out + "</dl>";
}

}  // namespace

std::string status_part(const CalibrationResult& result, const Rig* rig) {
  const std::vector<RecordingFault> all_faults = recording_faults(result.packets, result.clocks);
  const FaultsBySensor faults = by_sensor(all_faults);
  std::string out = std::string("<header class=\"") + to_string(result.status) + "\"><p class=\"what\">Calibration" +
                    (rig == nullptr || rig->name.empty() ? std::string() : " of " + html_text(rig->name)) + ", " +
                    html_text(result.method) + ", base " + html_text(result.base) + "</p><h1>" + badge(result.status) +
                    " " + html_text(summary_sentence(result)) + "</h1>" + faults_sentence(result.status, all_faults) +
                    "</header>\n";
  // What is wrong stands above what happened, and that above what is well.
  std::string wrong;
  std::string well;
  for (const SensorResult* sensor : worst_first(result, faults)) {
    const bool is_well = sensor->status == Status::good && faults.count(sensor->name) == 0;
    (is_well ? well : wrong) += card(result, *sensor, rig, faults);
  }
  return out + cards(wrong) + warnings_of(result.warnings, all_faults) + cards(well) + facts(result) + "\n";
}

}  // namespace rigcal::html
