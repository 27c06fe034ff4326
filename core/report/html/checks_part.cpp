// What the verdict rests on: stops that were held out, and how the solver came to rest.
#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/svg_plot.h"

namespace rigcal::html {
namespace {

std::string with_unit(double value, const std::string& unit) {
  if (!(value > 0.0)) return "–";
  return unit == "m" ? fixed_text(1e3 * value, 2) + " mm" : fixed_text(value, 2) + " " + unit;
}

std::string hold_out_bars(const std::vector<const SensorResult*>& sensors) {
  PlotAxis names{"", 0.0, 1.0, false, {}};
  double high = 3.0;
  for (const SensorResult* sensor : sensors) {
    names.categories.push_back(sensor->name);
    high = std::max(high, 1.15 * sensor->hold_out.ratio);
  }
  SvgPlot plot(760, 80 + 30 * static_cast<int>(sensors.size()), {"rms over what noise explains", 0.0, high}, names,
               "Residuals of held-out stops over their expected noise");
  for (std::size_t i = 0; i < sensors.size(); ++i) {
    const double ratio = sensors[i]->hold_out.ratio;
    plot.bar(static_cast<int>(i), 0, 1, ratio, ratio > 2.0 ? 4 : result_series,
             sensors[i]->name + ": " + fixed_text(ratio, 2));
  }
  const double rows = static_cast<double>(sensors.size());
  plot.line({{1.0, -0.5}, {1.0, rows - 0.5}}, 2, true);
  plot.line({{2.0, -0.5}, {2.0, rows - 0.5}}, 4, true);
  plot.legend("1: as noise explains", 2);
  plot.legend("2: the limit for good", 4);
  return plot.svg();
}

}  // namespace

std::string hold_out_part(const CalibrationResult& result) {
  std::vector<const SensorResult*> sensors;
  std::vector<std::vector<std::string>> rows;
  for (const SensorResult& sensor : result.sensors) {
    const HoldOutFigures& figures = sensor.hold_out;
    if (!(figures.ratio > 0.0)) continue;
    sensors.push_back(&sensor);
    rows.push_back({sensor.name, with_unit(figures.start_rms, figures.unit), with_unit(figures.rms, figures.unit),
                    fixed_text(figures.ratio, 2)});
  }
  if (rows.empty()) return {};
  return section("hold-out", "Stops that were held out",
                 figure(hold_out_bars(sensors),
                        "Every fourth stop is left out, the rest is solved again, and its place "
                        "there is compared with what the sensor saw.") +
                     table({"sensor", "at the guess, rms", "at the result, rms", "over expected noise"}, rows));
}

std::string convergence_part(const CalibrationResult& result) {
  // What noise adds is taken out of costs, so that they may be negative: what each iteration took off them is drawn.
  constexpr double least = 1e-6;  // nothing, but for rounding
  double high = 0.0;
  int steps = 0;
  std::vector<std::vector<std::vector<PlotPoint>>> lines;  // of each stage that has any, pass by pass
  for (const StageReport& stage : result.stages) {
    lines.emplace_back();
    for (const std::vector<double>& pass : stage.costs) {
      std::vector<PlotPoint> points;
      for (std::size_t k = 1; k < pass.size(); ++k) {
        const double taken_off = pass[k - 1] - pass[k];
        if (std::isfinite(taken_off)) points.push_back({static_cast<double>(++steps), std::max(taken_off, least)});
      }
      for (const PlotPoint& point : points) high = std::max(high, point.y);
      if (!points.empty()) lines.back().push_back(std::move(points));
    }
  }
  if (steps == 0) return {};
  SvgPlot plot(760, 320, {"iteration", 0.5, static_cast<double>(steps) + 0.5},
               {"taken off the cost", 0.5 * least, 2.0 * std::max(high, 1.0), true},
               "What each iteration took off the cost");
  int series = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    if (lines[k].empty()) continue;
    for (const std::vector<PlotPoint>& points : lines[k]) {
      plot.line(points, series);
      plot.dots(points, series);
    }
    plot.legend(result.stages[k].name, series++);
  }
  std::vector<std::vector<std::string>> rows;
  for (const StageReport& stage : result.stages) {
    std::string counts;
    for (const auto& [name, value] : stage.counts) {
      counts += (counts.empty() ? "" : ", ") + name + " " + fixed_text(value, 0);
    }
    rows.push_back({stage.name, fixed_text(stage.wall_s, 2), std::to_string(stage.iterations),
                    fixed_text(stage.peak_memory_mb, 0), counts});
  }
  return section("convergence", "How the solver came to rest",
                 figure(plot.svg(),
                        "How much smaller each iteration made the sum of squared distances over noise. Each line is a "
                        "map of planes: where one ends the planes are looked for anew. A line that ends high was "
                        "stopped too early; below 0.01 nothing moves that anyone could see.") +
                     table({"stage", "s", "iterations", "peak memory, MB", "counts"}, rows));
}

}  // namespace rigcal::html
