#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/speed/experiment.h"
#include "apps/experiment/svg_file.h"
#include "core/base/text.h"
#include "core/report/svg_plot.h"

namespace rigcal::speed {
namespace {

using Json = nlohmann::ordered_json;

struct Curve {
  const char* name;
  double GrowthRow::*value;
};
constexpr Curve time_curves[] = {{"calibration", &GrowthRow::calibration_s},
                                 {"one iteration", &GrowthRow::iteration_s},
                                 {"map", &GrowthRow::map_s},
                                 {"cells", &GrowthRow::cells_s}};
constexpr Curve memory_curves[] = {{"beside the points", &GrowthRow::memory_mb}};
constexpr const char* grown_by[] = {"points", "stops", "LiDARs", "voxels"};

// The axis that holds the values with some room, in whole powers of ten and halves of them.
PlotAxis log_axis(const std::string& label, double low, double high) { return {label, low / 1.3, high * 1.3, true}; }

template <std::size_t n>
std::string growth_svg(const std::vector<GrowthRow>& rows, const std::string& by, const Curve (&curves)[n],
                       const std::string& label, const std::string& title) {
  double low = 1e30, high = 0.0, least = 1e30, most = 0.0;
  for (const GrowthRow& row : rows) {
    if (row.by != by) continue;
    least = std::min(least, row.size);
    most = std::max(most, row.size);
    for (const Curve& curve : curves) {
      if (!(row.*curve.value > 0.0)) continue;
      low = std::min(low, row.*curve.value);
      high = std::max(high, row.*curve.value);
    }
  }
  if (high == 0.0) return {};
  SvgPlot plot(520, 340, log_axis(by, least, most), log_axis(label, low, high), title);
  int series = 0;
  for (const Curve& curve : curves) {
    std::vector<PlotPoint> line;
    for (const GrowthRow& row : rows) {
      if (row.by == by && row.*curve.value > 0.0) line.push_back({row.size, row.*curve.value});
    }
    if (!line.empty()) {
      plot.line(line, series);
      plot.dots(line, series);
      plot.legend(curve.name, series);
    }
    ++series;
  }
  return svg_file(plot.svg());
}

std::string stages_csv(const Experiment& experiment) {
  std::string text = "points,stage,seconds,cpu_s,bytes,share_of_reading\n";
  for (const StageTable& table : experiment.tables) {
    for (const StageSpeed& stage : table.stages) {
      text += fmt::format("{},{},{:.6f},{:.6f},{:.0f},{:.5f}\n", table.points, stage.stage, stage.seconds, stage.cpu_s,
                          stage.bytes, stage.bytes / stage.seconds / experiment.bandwidth.read_bytes_per_s);
    }
  }
  return text;
}

std::string growth_csv(const std::vector<GrowthRow>& rows) {
  std::string text = "by,size,cells_s,map_s,iteration_s,calibration_s,memory_mb\n";
  for (const GrowthRow& row : rows) {
    text += fmt::format("{},{:.0f},{:.6f},{:.6f},{:.6f},{:.6f},{:.1f}\n", row.by, row.size, row.cells_s, row.map_s,
                        row.iteration_s, row.calibration_s, row.memory_mb);
  }
  return text;
}

Json json_of(const StageTable& table, const Bandwidth& bandwidth) {
  Json stages = Json::array();
  for (const StageSpeed& stage : table.stages) {
    stages.push_back({{"stage", stage.stage},
                      {"seconds", stage.seconds},
                      {"cpu_s", stage.cpu_s},
                      {"bytes", stage.bytes},
                      {"share_of_reading", stage.bytes / stage.seconds / bandwidth.read_bytes_per_s}});
  }
  return {{"points", table.points},
          {"lidars", table.lidars},
          {"stops", table.stops},
          {"cells", table.cells},
          {"planes", table.planes},
          {"observations", table.observations},
          {"memory_mb", table.memory_mb},
          {"worst_m", table.worst_m},
          {"points_to_extrinsics_s", table.calibration_s()},
          {"points_to_extrinsics_cpu_s", table.calibration_cpu_s},
          {"stages", stages}};
}

Json json_of(const ProgramRun& run) {
  Json stages = Json::array();
  for (const auto& [name, s] : run.stages) stages.push_back({{"stage", name}, {"seconds", s}});
  return {{"name", run.name},
          {"wall_s", run.wall_s},
          {"first_wall_s", run.first_wall_s},
          {"runs", run.runs},
          {"cpu_s", run.cpu_s},
          {"peak_mb", run.peak_mb},
          {"points", run.points},
          {"input_mb", run.input_mb},
          {"found", run.found},
          {"worst_m", run.worst_m},
          {"extrinsics_s", run.until_lidars_s()},
          {"cameras_s", run.cameras_s()},
          {"stages", stages}};
}

Json json_of(const GrowthRow& row) {
  return {{"by", row.by},
          {"size", row.size},
          {"cells_s", row.cells_s},
          {"map_s", row.map_s},
          {"iteration_s", row.iteration_s},
          {"calibration_s", row.calibration_s},
          {"memory_mb", row.memory_mb}};
}

}  // namespace

std::string experiment_json(const Experiment& experiment) {
  Json json = experiment_head("speed");
  json["threads"] = experiment.threads;
  json["read_bytes_per_s"] = experiment.bandwidth.read_bytes_per_s;
  json["copy_bytes_per_s"] = experiment.bandwidth.copy_bytes_per_s;
  json["goals"] = Json::array();
  for (const Goal& goal : goals_of(experiment)) {
    json["goals"].push_back({{"what", goal.what},
                             {"measured", goal.measured},
                             {"goal", goal.goal},
                             {"known", goal.known},
                             {"unit", goal.unit},
                             {"met", goal.measured <= goal.goal}});
  }
  for (const ProgramRun& run : experiment.programs) json["programs"].push_back(json_of(run));
  for (const StageTable& table : experiment.tables) json["stages"].push_back(json_of(table, experiment.bandwidth));
  if (experiment.scans) {
    const ManyScans& scans = *experiment.scans;
    json["scans"] = {{"scans", scans.table.stops},
                     {"points", scans.table.points},
                     {"planes", scans.table.planes},
                     {"pairs", scans.table.observations},
                     {"map_s", scans.map_s},
                     {"map_cpu_s", scans.map_cpu_s},
                     {"iteration_cpu_s", scans.iteration_cpu_s},
                     {"iteration_s", scans.iteration_s}};
  }
  for (const GrowthRow& row : experiment.growth) json["growth"].push_back(json_of(row));
  return json_text(json);
}

std::vector<std::pair<std::string, std::string>> experiment_files(const Experiment& experiment) {
  std::vector<std::pair<std::string, std::string>> out;
  if (!experiment.tables.empty()) out.emplace_back("stages.csv", stages_csv(experiment));
  if (experiment.growth.empty()) return out;
  out.emplace_back("growth.csv", growth_csv(experiment.growth));
  for (const char* by : grown_by) {
    const std::string title = std::string(" of a calibration by ") + by;
    out.emplace_back("time_by_" + small_letters(by) + ".svg",
                     growth_svg(experiment.growth, by, time_curves, "seconds of processor", "Time" + title));
    std::string memory = growth_svg(experiment.growth, by, memory_curves, "MB beside the points", "Memory" + title);
    if (!memory.empty()) out.emplace_back("memory_by_" + small_letters(by) + ".svg", std::move(memory));
  }
  return out;
}

std::vector<std::string> experiment_file_names() {
  std::vector<std::string> names{"stages.csv", "growth.csv"};
  for (const char* by : grown_by) {
    names.push_back("time_by_" + small_letters(by) + ".svg");
    names.push_back("memory_by_" + small_letters(by) + ".svg");
  }
  return names;
}

}  // namespace rigcal::speed
