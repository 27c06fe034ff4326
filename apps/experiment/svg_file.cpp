#include "apps/experiment/svg_file.h"

#include <fmt/format.h>

#include "core/report/palette.h"

namespace rigcal {

std::string svg_file(std::string svg) {
  std::string style = "<style>.plot-text{font:11px sans-serif;fill:#444}.plot-grid{stroke:#ddd}.plot-axis{stroke:#666}";
  for (std::size_t s = 0; s < series_rgb.size(); ++s) {
    const auto& c = series_colour(s);
    style +=
        fmt::format(".s{0}{{fill:rgb({1},{2},{3});stroke:none}}.plot-line.s{0}{{fill:none;stroke:rgb({1},{2},{3})}}", s,
                    c[0], c[1], c[2]);
  }
  style += ".plot-line{stroke-width:2}.plot-line.dashed{stroke-dasharray:5 4}";
  const std::size_t end = svg.find('>');
  svg.insert(end + 1, style + "</style>");
  svg.insert(svg.find("<svg") + 4, " xmlns=\"http://www.w3.org/2000/svg\"");
  return svg + "\n";
}

}  // namespace rigcal
