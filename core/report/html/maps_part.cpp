// The fused cloud from above and from the side, with the guess and with the result.
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/median.h"
#include "core/base/text.h"
#include "core/report/dot_picture.h"
#include "core/report/html/parts.h"
#include "core/report/html_text.h"
#include "core/report/palette.h"
#include "core/report/svg_plot.h"

namespace rigcal::html {
namespace {

constexpr int picture_width = 760;
constexpr int most_rows = 720;
constexpr double top_slice_m = 0.3;  // half of the thickness of what is shown
constexpr double side_slice_m = 0.5;
constexpr double least_extent_m = 1.0;

// Which coordinates go right and up, and which one is cut.
struct View {
  const char* name;
  const char* words;
  int right;
  int up;
  int cut;
  double half_slice_m;
};

constexpr View top{"From above", "of the base's height", 0, 1, 2, top_slice_m};
constexpr View side{"From the side", "of the base, left and right", 0, 2, 1, side_slice_m};

double coordinate(const MapPoint& p, int axis) { return axis == 0 ? p.x : axis == 1 ? p.y : p.z; }

struct Range {
  double low = 0.0;
  double high = 0.0;
};

// Without the few points that are far from all others.
Range extent(std::vector<double>& values) {
  const Range inner{quantile(values, 0.01), quantile(values, 0.99)};
  const double room = 0.05 * (inner.high - inner.low) + least_extent_m / 2;
  return {inner.low - room, inner.high + room};
}

struct Window {
  Range right;
  Range up;
};

bool is_in_slice(const MapPoint& p, const View& view) {
  return std::abs(coordinate(p, view.cut)) <= view.half_slice_m && std::isfinite(p.x + p.y + p.z);
}

// Thicker where next to nothing lies in the slice: on an open road there is little at the height of a roof.
View with_enough_in_it(const std::vector<MapPoint>& map, View view) {
  constexpr double least_share = 0.05;
  constexpr double most_m = 20.0;
  const auto share = [&] {
    const auto count = std::count_if(map.begin(), map.end(), [&](const MapPoint& p) { return is_in_slice(p, view); });
    return static_cast<double>(count) / static_cast<double>(map.size());
  };
  while (view.half_slice_m < most_m && share() < least_share) view.half_slice_m *= 2.0;
  return view;
}

std::optional<Window> window_of(const std::vector<MapPoint>& map, const View& view) {
  std::vector<double> right;
  std::vector<double> up;
  for (const MapPoint& p : map) {
    if (!is_in_slice(p, view)) continue;
    right.push_back(coordinate(p, view.right));
    up.push_back(coordinate(p, view.up));
  }
  if (right.empty()) return std::nullopt;
  return Window{extent(right), extent(up)};
}

std::string draw(const std::vector<MapPoint>& map, const View& view, const Window& window, const std::string& title,
                 std::vector<char>& shown) {
  // Axes and labels take some of the width; the rest has square pixels.
  const double metres = window.right.high - window.right.low;
  const int columns = 2 * (picture_width - 76);
  const int rows =
      std::clamp(static_cast<int>(columns * (window.up.high - window.up.low) / metres), 120, 2 * most_rows);
  DotPicture picture(columns, rows);
  for (const MapPoint& p : map) {
    if (!is_in_slice(p, view)) continue;
    if (p.sensor < shown.size()) shown[p.sensor] = 1;
    picture.dot((coordinate(p, view.right) - window.right.low) / metres * columns,
                (window.up.high - coordinate(p, view.up)) / (window.up.high - window.up.low) * rows,
                series_colour(p.sensor));
  }
  SvgPlot plot(picture_width, rows / 2 + 76,
               {std::string(1, "xyz"[view.right]) + ", m", window.right.low, window.right.high},
               {std::string(1, "xyz"[view.up]) + ", m", window.up.low, window.up.high}, title);
  plot.image("image/png", base64(picture.png()));
  return plot.svg();
}

std::string pair_of(const CalibrationResult& result, const View& usual, std::vector<char>& shown) {
  if (result.map.empty()) return {};
  const View view = with_enough_in_it(result.map, usual);
  const auto window = window_of(result.map, view);
  if (!window) return {};
  const std::string words =
      "what lies within " + fixed_text(view.half_slice_m, 1) + " m " + view.words + ", in the world frame";
  std::string out;
  if (!result.map_at_guess.empty()) {
    out += figure(
        draw(result.map_at_guess, view, *window, std::string(view.name) + ", before", shown),
        std::string("<b>") + view.name + ", before:</b> sensors at the guess, poses of the result; " + words + ".");
  }
  return out + figure(draw(result.map, view, *window, std::string(view.name) + ", after", shown),
                      std::string("<b>") + view.name + ", after;</b> " + words + ".");
}

}  // namespace

std::string maps_part(const CalibrationResult& result) {
  std::vector<char> shown(result.sensors.size(), 0);
  const std::string pictures = pair_of(result, top, shown) + pair_of(result, side, shown);
  if (pictures.empty()) return {};
  return section("maps", "The cloud before and after",
                 paragraph("Where the sensors sit right, walls that were double are single afterwards. " +
                           colour_key(result, shown)) +
                     "<div class=\"pairs\">" + pictures + "</div>");
}

}  // namespace rigcal::html
