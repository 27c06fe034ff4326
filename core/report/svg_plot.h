#pragma once

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace rigcal {

/// A picture's axis. With `categories`, category i lies at i and the range is ignored.
struct PlotAxis {
  std::string label;
  double low = 0.0;
  double high = 1.0;
  bool log = false;
  std::vector<std::string> categories = {};
};

struct PlotPoint {
  double x = 0.0;
  double y = 0.0;
};

/// The one way in which pages draw: an SVG picture of axes with ticks, lines, dots, bars, boxes and images, and a
/// legend. It has no colours of its own but the classes `s0` .. `s7` of its series, `plot-axis`, `plot-grid` and
/// `plot-text`, so that the page's style decides, by light and dark alike. What lies outside the axes is cut off.
class SvgPlot {
 public:
  /// `width` and `height` in pixels of the whole; `title` is what readers of the screen read out.
  SvgPlot(int width, int height, PlotAxis x, PlotAxis y, std::string title);

  /// Series are coloured in the order of their numbers, again from the first after the eighth.
  void line(const std::vector<PlotPoint>& points, int series, bool dashed = false);
  void dots(const std::vector<PlotPoint>& points, int series, double radius_px = 2.5);
  /// A box from corner to corner. `remark` is shown where the pointer rests.
  void box(PlotPoint from, PlotPoint to, int series, const std::string& remark = {}, double opacity = 1.0);
  /// A bar at category `category` from the lower end of the value axis, the `k`th of `of` side by side.
  void bar(int category, int k, int of, double value, int series, const std::string& remark);
  /// A PNG or JPEG file's bytes, base64, over the whole of the axes.
  void image(std::string_view media_type, std::string_view base64);
  void legend(const std::string& text, int series);

  [[nodiscard]] std::string svg() const;

 private:
  [[nodiscard]] double to_x(double value) const;
  [[nodiscard]] double to_y(double value) const;
  [[nodiscard]] int left() const;
  [[nodiscard]] std::string axes() const;

  int width_;
  int height_;
  PlotAxis x_;
  PlotAxis y_;
  std::string title_;
  std::string content_;
  std::vector<std::pair<std::string, int>> legend_;
};

/// Round numbers from `low` to `high`, about `count` of them: 1, 2 or 5 times a power of ten apart.
[[nodiscard]] std::vector<double> linear_ticks(double low, double high, int count);
/// The powers of ten from `low` to `high`; with few of them also 2 and 5 times these.
[[nodiscard]] std::vector<double> log_ticks(double low, double high);

}  // namespace rigcal
