#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/experiment/svg_file.h"
#include "apps/experiment/targetless/experiment.h"
#include "core/geometry/se3.h"
#include "core/report/svg_plot.h"

namespace rigcal::targetless {
namespace {

std::string iterations_csv(const IterationsExperiment& experiment) {
  std::string text = "method,iteration,rotation_deg,rotation_spread_deg,translation_m,translation_spread_m,right\n";
  for (const MethodIterations& method : experiment.methods) {
    for (std::size_t k = 0; k < method.after.size(); ++k) {
      const IterationFigures& f = method.after[k];
      text += fmt::format("{},{},{:.6f},{:.6f},{:.6f},{:.6f},{}\n", method.method, k, to_deg(f.rotation_rad.mean),
                          to_deg(f.rotation_rad.spread), f.translation_m.mean, f.translation_m.spread, f.right);
    }
  }
  return text;
}

std::string basin_csv(const std::vector<BasinCell>& cells) {
  std::string text = "rotation_deg,translation_m,method,trials,right,median_rotation_deg,median_translation_m\n";
  for (const BasinCell& cell : cells) {
    text += fmt::format("{},{},{},{},{},{:.6f},{:.6f}\n", cell.rotation_deg, cell.translation_m, cell.method,
                        cell.trials, cell.right, to_deg(cell.median_rotation_rad), cell.median_translation_m);
  }
  return text;
}

// Means as a line, spreads as boxes around them, as in Fig. 10; `scale` from what `of` gives to the axis' unit.
template <class Of>
std::string iterations_svg(const IterationsExperiment& experiment, const PlotAxis& y, double scale, const Of& of,
                           const std::string& title) {
  std::size_t longest = 1;
  for (const MethodIterations& method : experiment.methods) longest = std::max(longest, method.after.size());
  SvgPlot plot(640, 360, {"iteration", -0.5, static_cast<double>(longest) - 0.5}, y, title);
  int series = 0;
  for (const MethodIterations& method : experiment.methods) {
    std::vector<PlotPoint> line;
    for (std::size_t k = 0; k < method.after.size(); ++k) {
      const MeanSpread& figures = of(method.after[k]);
      const double mean = scale * figures.mean;
      const double spread = scale * figures.spread;
      const double x = static_cast<double>(k);
      line.push_back({x, std::max(mean, y.low)});
      plot.box({x - 0.25, std::max(mean - spread, y.low)}, {x + 0.25, std::max(mean + spread, y.low)}, series,
               fmt::format("{} after {}: {:.4g} +- {:.4g}", method.method, k, mean, spread), 0.3);
    }
    plot.line(line, series);
    plot.dots(line, series);
    plot.legend(method.method, series++);
  }
  return svg_file(plot.svg());
}

std::string chain_csv(const std::vector<ChainRow>& rows) {
  std::string text =
      "rig,scene,method,pairs,found,rotation_deg,rotation_spread_deg,translation_m,translation_spread_m\n";
  for (const ChainRow& row : rows) {
    text += fmt::format("{},{},{},{},{},{:.6f},{:.6f},{:.6f},{:.6f}\n", row.rig, row.scene, row.method, row.pairs,
                        row.found, to_deg(row.rotation_rad.mean), to_deg(row.rotation_rad.spread),
                        row.translation_m.mean, row.translation_m.spread);
  }
  return text;
}

std::string time_csv(const TimeExperiment& time) {
  std::string text = "method,stage,match_s,solve_s,matched\n";
  for (const StageSeconds& row : time.stages)
    text += fmt::format("{},{},{:.6f},{:.6f},{}\n", row.method, row.stage, row.match_s, row.solve_s, row.matched);
  return text;
}

// Where a name stands in the order of their first mention.
int place_of(std::vector<std::string>& names, const std::string& name) {
  const auto at = std::find(names.begin(), names.end(), name);
  if (at != names.end()) return static_cast<int>(at - names.begin());
  names.push_back(name);
  return static_cast<int>(names.size()) - 1;
}

// A bar for each method in each setting, on a logarithmic axis; `setting` and `value` of a row.
template <class Row, class Setting, class Value>
std::string bars_svg(const std::vector<Row>& rows, const PlotAxis& y, const Setting& setting, const Value& value,
                     const std::string& title) {
  std::vector<std::string> settings;
  std::vector<std::string> methods;
  for (const Row& row : rows) {
    place_of(settings, setting(row));
    place_of(methods, row.method);
  }
  SvgPlot plot(760, 340, {"", 0.0, 1.0, false, settings}, y, title);
  for (const Row& row : rows) {
    if (row.found == 0) continue;
    const int method = place_of(methods, row.method);
    plot.bar(place_of(settings, setting(row)), method, static_cast<int>(methods.size()), value(row), method,
             fmt::format("{}: {:.4g}", row.method, value(row)));
  }
  for (std::size_t k = 0; k < methods.size(); ++k) plot.legend(methods[k], static_cast<int>(k));
  return svg_file(plot.svg());
}

std::string camera_time_csv(const std::vector<CameraSeconds>& rows) {
  std::string text = "method,planes_s,edges_s,match_s,solve_s,voxels,edge_points\n";
  for (const CameraSeconds& row : rows)
    text += fmt::format("{},{:.6f},{:.6f},{:.6f},{:.6f},{},{}\n", row.method, row.planes_s, row.edges_s, row.match_s,
                        row.solve_s, row.voxels, row.edge_points);
  return text;
}

std::string cameras_csv(const CameraExperiment& experiment) {
  std::string text =
      "pair,lidar,overlaps,method,trials,found,rotation_deg,rotation_spread_deg,translation_m,translation_spread_m,"
      "median_rotation_deg,median_translation_m,seconds\n";
  for (const CameraRow& row : experiment.rows)
    text += fmt::format("{},{},{},{},{},{},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.3f}\n", row.pair, row.lidar,
                        row.overlaps ? 1 : 0, row.method, row.trials, row.found, to_deg(row.rotation_rad.mean),
                        to_deg(row.rotation_rad.spread), row.translation_m.mean, row.translation_m.spread,
                        to_deg(row.median_rotation_rad), row.median_translation_m, row.seconds);
  return text;
}

std::string basin_svg(const std::vector<BasinCell>& cells) {
  std::vector<std::string> guesses;
  std::vector<std::string> methods;
  const auto guess_of = [](const BasinCell& cell) {
    return fmt::format("{:.0f}° {:.1f} m", cell.rotation_deg, cell.translation_m);
  };
  for (const BasinCell& cell : cells) {
    place_of(guesses, guess_of(cell));
    place_of(methods, cell.method);
  }
  SvgPlot plot(860, 340, {"guesses off by up to, each axis", 0.0, 1.0, false, guesses},
               {"trials that are right, %", 0.0, 105.0}, "How far off guesses may be");
  for (const BasinCell& cell : cells) {
    const int method = place_of(methods, cell.method);
    const double share = 100.0 * cell.right / std::max(cell.trials, 1);
    plot.bar(place_of(guesses, guess_of(cell)), method, static_cast<int>(methods.size()), share, method,
             fmt::format("{}: {} of {}", cell.method, cell.right, cell.trials));
  }
  for (std::size_t k = 0; k < methods.size(); ++k) plot.legend(methods[k], static_cast<int>(k));
  return svg_file(plot.svg());
}

}  // namespace

std::vector<std::pair<std::string, std::string>> experiment_files(const Experiment& experiment) {
  std::vector<std::pair<std::string, std::string>> out;
  if (experiment.iterations) {
    const IterationsExperiment& iterations = *experiment.iterations;
    out.emplace_back("iterations.csv", iterations_csv(iterations));
    out.emplace_back("iterations_rotation.svg",
                     iterations_svg(
                         iterations, {"rotation error, degrees", 1e-3, 30.0, true}, to_deg(1.0),
                         [](const IterationFigures& f) { return f.rotation_rad; }, "Rotation error by iteration"));
    out.emplace_back("iterations_translation.svg",
                     iterations_svg(
                         iterations, {"translation error, mm", 0.2, 1000.0, true}, 1e3,
                         [](const IterationFigures& f) { return f.translation_m; }, "Translation error by iteration"));
  }
  if (!experiment.basin.empty()) {
    out.emplace_back("basin.csv", basin_csv(experiment.basin));
    out.emplace_back("basin.svg", basin_svg(experiment.basin));
  }
  if (!experiment.chain.empty()) {
    out.emplace_back("chain.csv", chain_csv(experiment.chain));
    const auto setting = [](const ChainRow& row) { return row.rig + " " + row.scene; };
    out.emplace_back("chain_rotation.svg", bars_svg(
                                               experiment.chain, {"rotation error, degrees", 1e-3, 30.0, true}, setting,
                                               [](const ChainRow& row) { return to_deg(row.rotation_rad.mean); },
                                               "Rotation error of a MID-100's units"));
    out.emplace_back("chain_translation.svg",
                     bars_svg(
                         experiment.chain, {"translation error, mm", 0.2, 10000.0, true}, setting,
                         [](const ChainRow& row) { return 1e3 * row.translation_m.mean; },
                         "Translation error of a MID-100's units"));
  }
  if (experiment.time) out.emplace_back("time.csv", time_csv(*experiment.time));
  if (!experiment.camera_time.empty()) out.emplace_back("camera_time.csv", camera_time_csv(experiment.camera_time));
  if (experiment.cameras) {
    const std::vector<CameraRow>& rows = experiment.cameras->rows;
    const auto setting = [](const CameraRow& row) {
      return (row.pair == "camera to camera" ? "cameras, " : "camera, ") +
             std::string(row.overlaps ? "overlap" : "no overlap");
    };
    out.emplace_back("cameras.csv", cameras_csv(*experiment.cameras));
    out.emplace_back("cameras_rotation.svg", bars_svg(
                                                 rows, {"rotation error, degrees", 1e-3, 30.0, true}, setting,
                                                 [](const CameraRow& row) { return to_deg(row.rotation_rad.mean); },
                                                 "Rotation error of cameras"));
    out.emplace_back("cameras_translation.svg", bars_svg(
                                                    rows, {"translation error, mm", 0.2, 10000.0, true}, setting,
                                                    [](const CameraRow& row) { return 1e3 * row.translation_m.mean; },
                                                    "Translation error of cameras"));
  }
  return out;
}

std::vector<std::string> experiment_file_names() {
  return {"iterations.csv", "iterations_rotation.svg", "iterations_translation.svg", "basin.csv", "basin.svg",
          "chain.csv",      "chain_rotation.svg",      "chain_translation.svg",      "time.csv",  "camera_time.csv",
          "cameras.csv",    "cameras_rotation.svg",    "cameras_translation.svg"};
}

}  // namespace rigcal::targetless
