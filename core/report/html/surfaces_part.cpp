// How thick the surfaces are that several sensors see: numbers, and some of them cut open.
#include <algorithm>
#include <cmath>

#include "core/base/text.h"
#include "core/report/dot_picture.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/palette.h"
#include "core/report/svg_plot.h"

namespace rigcal::html {
namespace {

std::string pair_name(const SharedSurfaces& pair) {
  return pair.first.empty() ? "all pairs" : pair.first + " – " + pair.second;
}

std::string mm(double m) { return fixed_text(1e3 * m, m < 0.1 ? 2 : 0); }

std::string bars_of(const std::vector<SharedSurfaces>& pairs) {
  PlotAxis names{"", 0.0, 1.0, false, {}};
  double low = 1e9;
  double high = 0.0;
  for (const SharedSurfaces& pair : pairs) {
    names.categories.push_back(pair_name(pair));
    low = std::min({low, 1e3 * pair.before_m, 1e3 * pair.after_m});
    high = std::max({high, 1e3 * pair.before_m, 1e3 * pair.after_m});
  }
  low = std::pow(10.0, std::floor(std::log10(std::max(0.7 * low, 1e-3))));
  high = std::max(high * 1.2, low * 10.0);
  SvgPlot plot(760, 80 + 34 * static_cast<int>(pairs.size()), {"thickness, mm, rms", low, high, true}, names,
               "Thickness of surfaces that two sensors see");
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const int row = static_cast<int>(i);
    plot.bar(row, 0, 2, 1e3 * pairs[i].before_m, guess_series,
             pair_name(pairs[i]) + ", guess: " + mm(pairs[i].before_m) + " mm");
    plot.bar(row, 1, 2, 1e3 * pairs[i].after_m, result_series,
             pair_name(pairs[i]) + ", result: " + mm(pairs[i].after_m) + " mm");
  }
  plot.legend("at the guess", guess_series);
  plot.legend("at the result", result_series);
  return plot.svg();
}

std::string cut_picture(const SurfaceCut& cut, const std::vector<SurfaceCut::Dot>& dots, double half_depth_m,
                        const std::string& title, std::vector<char>& shown) {
  constexpr int columns = 640;
  constexpr int rows = 360;
  DotPicture picture(columns, rows);
  for (const SurfaceCut::Dot& dot : dots) {
    if (dot.sensor < shown.size()) shown[dot.sensor] = 1;
    const double x = (dot.along_m + cut.half_length_m) / (2.0 * cut.half_length_m) * columns;
    const double y = (half_depth_m - dot.off_m) / (2.0 * half_depth_m) * rows;
    picture.dot(x, y, series_colour(dot.sensor));
  }
  const bool small = half_depth_m < 0.1;
  const double unit = small ? 1e3 : 1.0;
  SvgPlot plot(396, 256, {"along the surface, m", -cut.half_length_m, cut.half_length_m},
               {small ? "off it, mm" : "off it, m", -unit * half_depth_m, unit * half_depth_m}, title);
  plot.image("image/png", base64(picture.png()));
  return plot.svg();
}

std::string words_of(const Vector3d& v) {
  return "(" + fixed_text(v.x(), 2) + ", " + fixed_text(v.y(), 2) + ", " + fixed_text(v.z(), 2) + ")";
}

std::string cut_row(const SurfaceCut& cut, std::size_t number, std::vector<char>& shown) {
  constexpr double close_m = 0.05;
  const std::string name = "Surface " + std::to_string(number);
  std::string out =
      "<h3>" + name + "</h3>" +
      paragraph("At " + words_of(cut.center_G) + " m of the world frame, facing " + words_of(cut.normal_G) + ".") +
      "<div class=\"triples\">";
  out += figure(cut_picture(cut, cut.before, cut.half_depth_m, name + ", before", shown), "<b>Before</b>");
  out += figure(cut_picture(cut, cut.after, cut.half_depth_m, name + ", after", shown), "<b>After</b>, the same scale");
  if (cut.half_depth_m > close_m) {
    out += figure(cut_picture(cut, cut.after, close_m, name + ", after, magnified", shown),
                  "<b>After</b>, " + fixed_text(cut.half_depth_m / close_m, 1) + " times as large across");
  }
  return out + "</div>";
}

}  // namespace

std::string surfaces_part(const CalibrationResult& result) {
  std::string out;
  if (!result.shared_surfaces.empty()) {
    std::vector<std::vector<std::string>> rows;
    for (const SharedSurfaces& pair : result.shared_surfaces) {
      rows.push_back({pair_name(pair), std::to_string(pair.surfaces), mm(pair.before_m), mm(pair.after_m)});
    }
    out += figure(bars_of(result.shared_surfaces),
                  "By how much what one sensor sees of a surface stands off what the other sees of it.");
    out += table({"sensors", "surfaces", "before, mm", "after, mm"}, rows,
                 "Root mean square along the normal, each surface weighted by how well both sensors know it. Only "
                 "surfaces that the result puts together are in it: it is a fit, no accuracy.");
  }
  std::string cuts;
  std::vector<char> shown(result.sensors.size(), 0);
  for (std::size_t k = 0; k < result.cuts.size(); ++k) cuts += cut_row(result.cuts[k], k + 1, shown);
  if (!cuts.empty()) {
    out += paragraph("Surfaces cut open: the points of all stops within 15 cm of a line across. " +
                     colour_key(result, shown)) +
           cuts;
  }
  return section("surfaces", "How thick the walls are", out);
}

}  // namespace rigcal::html
