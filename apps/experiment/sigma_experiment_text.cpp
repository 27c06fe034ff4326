#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "apps/experiment/experiment_json.h"
#include "apps/experiment/sigma_experiment.h"
#include "apps/experiment/svg_file.h"
#include "core/geometry/se3.h"
#include "core/report/svg_plot.h"

namespace rigcal {
namespace {

using Json = nlohmann::ordered_json;

std::vector<std::string> scenes_of(const SigmaRow& row) {
  std::set<std::string> names;
  for (const SigmaTrial& trial : row.trials) names.insert(trial.scene);
  std::vector<std::string> out(names.begin(), names.end());
  out.emplace_back();
  return out;
}

// Chi-square with six degrees of freedom.
double share_below(double nees) {
  const double h = 0.5 * nees;
  return 1.0 - std::exp(-h) * (1.0 + h + 0.5 * h * h);
}

constexpr double widest_nees = 20.0;

}  // namespace

std::string sigma_experiment_text(const std::vector<SigmaRow>& rows) {
  std::string text =
      "Errors of LiDARs over their sigma, squared (NEES, 6 degrees of freedom): a true sigma has a mean of 6,\n"
      "95 % and 68 % of the errors in the ellipsoids of that name\n"
      "scene       LiDARs  good  false alarms   NEES   in 95 %  in 68 %  good ones in 95 %   median error\n";
  for (const SigmaRow& row : rows) {
    text += fmt::format("{}: {} rigs{}\n", row.kind.name, row.rigs,
                        row.failed > 0 ? fmt::format(", {} LiDARs without an answer", row.failed) : "");
    for (const std::string& scene : scenes_of(row)) {
      const SigmaFigures f = sigma_figures(row, scene);
      text +=
          fmt::format("{:<11} {:>6} {:>5} {:>13} {:>6.2f} {:>7.1f} % {:>6.1f} % {:>16.1f} %   {:.2f} mm {:.4f} deg\n",
                      scene.empty() ? "all" : scene, f.lidars, f.good, f.false_alarms, f.mean_nees, 100.0 * f.within_95,
                      100.0 * f.within_68, 100.0 * f.good_within_95, 1e3 * f.median_m, to_deg(f.median_rad));
    }
  }
  return text;
}

std::string sigma_experiment_json(const std::vector<SigmaRow>& rows) {
  Json json = experiment_head("sigma");
  json["rows"] = Json::array();
  for (const SigmaRow& row : rows) {
    Json scenes = Json::array();
    for (const std::string& scene : scenes_of(row)) {
      const SigmaFigures f = sigma_figures(row, scene);
      scenes.push_back({{"scene", scene.empty() ? "all" : scene},
                        {"lidars", f.lidars},
                        {"good", f.good},
                        {"false_alarms", f.false_alarms},
                        {"mean_nees", f.mean_nees},
                        {"within_95", f.within_95},
                        {"within_68", f.within_68},
                        {"good_within_95", f.good_within_95},
                        {"median_translation_m", f.median_m},
                        {"median_rotation_rad", f.median_rad}});
    }
    json["rows"].push_back({{"errors", row.kind.name},
                            {"range_bias_m", row.kind.range_bias_m},
                            {"footprint_share", row.kind.footprint_share},
                            {"rigs", row.rigs},
                            {"failed", row.failed},
                            {"scenes", std::move(scenes)}});
  }
  return json_text(json);
}

std::string nees_svg(const std::vector<SigmaRow>& rows) {
  SvgPlot plot(640, 400, {"NEES, 6 degrees of freedom", 0.0, widest_nees}, {"share of errors below, %", 0.0, 100.0},
               "Errors over what sigma says");
  std::vector<PlotPoint> truth;
  for (int k = 0; k <= 100; ++k) {
    const double nees = widest_nees * k / 100.0;
    truth.push_back({nees, 100.0 * share_below(nees)});
  }
  plot.line(truth, 0, true);
  plot.legend("a true sigma", 0);
  int series = 1;
  for (const SigmaRow& row : rows) {
    std::vector<double> nees;
    for (const SigmaTrial& trial : row.trials) nees.push_back(trial.nees);
    std::sort(nees.begin(), nees.end());
    std::vector<PlotPoint> steps{{0.0, 0.0}};
    for (std::size_t k = 0; k < nees.size(); ++k) {
      const double x = std::min(nees[k], widest_nees);
      steps.push_back({x, steps.back().y});
      steps.push_back({x, 100.0 * static_cast<double>(k + 1) / static_cast<double>(nees.size())});
    }
    plot.line(steps, series);
    plot.legend(row.kind.name, series++);
  }
  return svg_file(plot.svg());
}

}  // namespace rigcal
