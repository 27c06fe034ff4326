#include "core/report/svg_plot.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/text.h"
#include "core/report/html_text.h"

namespace rigcal {
namespace {

// Room around the axes, pixels: numbers and labels stand in it.
constexpr int room_left = 62;
constexpr int room_right = 14;
constexpr int room_top = 30;
constexpr int room_bottom = 46;
constexpr int series_colours = 8;
// Of text of the size that the page gives it.
constexpr double character_px = 6.7;

std::string px(double value) { return fixed_text(value, 1); }

std::string attribute(const char* name, const std::string& value) {
  return std::string(" ") + name + "=\"" + value + "\"";
}

std::string series_class(int series) { return "s" + std::to_string(series % series_colours); }

std::string text_at(double x, double y, const std::string& anchor, const std::string& text, const std::string& more) {
  return "<text class=\"plot-text\"" + attribute("x", px(x)) + attribute("y", px(y)) +
         attribute("text-anchor", anchor) + more + ">" + html_text(text) + "</text>";
}

std::string stroke(double x1, double y1, double x2, double y2, const char* kind) {
  return "<line" + attribute("class", kind) + attribute("x1", px(x1)) + attribute("y1", px(y1)) +
         attribute("x2", px(x2)) + attribute("y2", px(y2)) + "/>";
}

// As short as it can be: 0.05, 2, 300, 20 k, 10^9.
std::string tick_text(double value, double step) {
  const double size = std::abs(value);
  if (size >= 1e4 && size < 1e9) {
    const bool millions = size >= 1e6;
    const double short_value = value / (millions ? 1e6 : 1e3);
    return fixed_text(short_value, short_value == std::round(short_value) ? 0 : 1) + (millions ? " M" : " k");
  }
  if (size >= 1e9 || (size > 0.0 && size < 1e-4)) {
    const int power = static_cast<int>(std::floor(std::log10(size) + 1e-9));
    const double factor = value / std::pow(10.0, power);
    const std::string head = std::abs(factor - 1.0) < 1e-6 ? "" : fixed_text(factor, 0) + "·";
    return head + "10^" + std::to_string(power);
  }
  const int digits = step >= 1.0 ? 0 : static_cast<int>(std::ceil(-std::log10(step) - 1e-9));
  return fixed_text(value + 0.0, digits);
}

double range_of(const PlotAxis& axis) {
  if (!axis.categories.empty()) return static_cast<double>(axis.categories.size());
  return axis.log ? std::log10(axis.high / axis.low) : axis.high - axis.low;
}

// 0 .. 1 along the axis.
double share_of(const PlotAxis& axis, double value) {
  if (!axis.categories.empty()) return (value + 0.5) / range_of(axis);
  if (axis.log) return std::log10(std::max(value, axis.low * 1e-3) / axis.low) / range_of(axis);
  return (value - axis.low) / range_of(axis);
}

struct Tick {
  double value = 0.0;
  std::string text;
};

std::vector<Tick> ticks_of(const PlotAxis& axis, int count) {
  std::vector<Tick> out;
  for (std::size_t i = 0; i < axis.categories.size(); ++i) out.push_back({static_cast<double>(i), axis.categories[i]});
  if (!out.empty()) return out;
  const std::vector<double> values =
      axis.log ? log_ticks(axis.low, axis.high) : linear_ticks(axis.low, axis.high, count);
  for (const double value : values) {
    out.push_back({value, tick_text(value, axis.log || values.size() < 2 ? value : values[1] - values[0])});
  }
  return out;
}

}  // namespace

std::vector<double> linear_ticks(double low, double high, int count) {
  if (!(high > low) || !std::isfinite(high - low)) return {low};
  const double rough = (high - low) / std::max(count, 1);
  const double power = std::pow(10.0, std::floor(std::log10(rough)));
  const double ratio = rough / power;
  const double step = power * (ratio > 5.0 ? 10.0 : ratio > 2.0 ? 5.0 : ratio > 1.0 ? 2.0 : 1.0);
  std::vector<double> out;
  // Counted in steps, so that sums do not drift.
  for (double k = std::ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; k += 1.0)
    out.push_back(k * step + 0.0);  // Never minus zero.
  return out;
}

std::vector<double> log_ticks(double low, double high) {
  if (!(low > 0.0) || !(high > low) || !std::isfinite(high)) return {low};
  const bool fine = std::log10(high / low) < 2.5;
  const int decades = static_cast<int>(std::ceil(std::log10(high / low)));
  const int skip = std::max(1, decades / 8);
  std::vector<double> out;
  for (int power = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, power) <= high; power += skip) {
    for (const double factor : {1.0, 2.0, 5.0}) {
      const double value = factor * std::pow(10.0, power);
      if ((factor == 1.0 || fine) && value >= low * (1.0 - 1e-9) && value <= high * (1.0 + 1e-9)) out.push_back(value);
    }
  }
  return out;
}

SvgPlot::SvgPlot(int width, int height, PlotAxis x, PlotAxis y, std::string title)
    : width_(width), height_(height), x_(std::move(x)), y_(std::move(y)), title_(std::move(title)) {}

int SvgPlot::left() const {
  std::size_t longest = 0;
  for (const std::string& name : y_.categories) longest = std::max(longest, name.size());
  const double wanted = character_px * static_cast<double>(longest) + 12.0;
  return std::clamp(static_cast<int>(wanted), room_left, width_ / 3);
}

double SvgPlot::to_x(double value) const { return left() + share_of(x_, value) * (width_ - left() - room_right); }

double SvgPlot::to_y(double value) const {
  const double rows = height_ - room_top - room_bottom;
  // Categories are read from the top, values from the bottom.
  const double share = share_of(y_, value);
  return room_top + (y_.categories.empty() ? 1.0 - share : share) * rows;
}

void SvgPlot::line(const std::vector<PlotPoint>& points, int series, bool dashed) {
  std::string path;
  for (const PlotPoint& p : points) path += (path.empty() ? "" : " ") + px(to_x(p.x)) + "," + px(to_y(p.y));
  content_ += "<polyline" + attribute("class", "plot-line " + series_class(series) + (dashed ? " dashed" : "")) +
              attribute("points", path) + "/>";
}

void SvgPlot::dots(const std::vector<PlotPoint>& points, int series, double radius_px) {
  for (const PlotPoint& p : points) {
    content_ += "<circle" + attribute("class", "plot-fill " + series_class(series)) + attribute("cx", px(to_x(p.x))) +
                attribute("cy", px(to_y(p.y))) + attribute("r", px(radius_px)) + "/>";
  }
}

void SvgPlot::box(PlotPoint from, PlotPoint to, int series, const std::string& remark, double opacity) {
  const double x1 = std::min(to_x(from.x), to_x(to.x));
  const double x2 = std::max(to_x(from.x), to_x(to.x));
  const double y1 = std::min(to_y(from.y), to_y(to.y));
  const double y2 = std::max(to_y(from.y), to_y(to.y));
  content_ += "<rect" + attribute("class", "plot-fill " + series_class(series)) + attribute("x", px(x1)) +
              attribute("y", px(y1)) + attribute("width", px(std::max(x2 - x1, 1.0))) +
              attribute("height", px(std::max(y2 - y1, 1.0)));
  if (opacity < 1.0) content_ += attribute("fill-opacity", fixed_text(opacity, 2));
  content_ += remark.empty() ? "/>" : "><title>" + html_text(remark) + "</title></rect>";
}

void SvgPlot::bar(int category, int k, int of, double value, int series, const std::string& remark) {
  const double width = 0.8 / of;
  const double begin = category - 0.4 + k * width;
  const bool across = !y_.categories.empty();
  const PlotAxis& axis = across ? x_ : y_;
  const double low = axis.low;
  const double end = std::clamp(value, low, axis.high);
  if (across) {
    box({low, begin}, {end, begin + 0.9 * width}, series, remark);
  } else {
    box({begin, low}, {begin + 0.9 * width, end}, series, remark);
  }
}

void SvgPlot::image(std::string_view media_type, std::string_view base64) {
  content_ += "<image" + attribute("x", px(left())) + attribute("y", px(room_top)) +
              attribute("width", px(width_ - left() - room_right)) +
              attribute("height", px(height_ - room_top - room_bottom)) +
              " preserveAspectRatio=\"none\" href=\"data:" + std::string(media_type) + ";base64," +
              std::string(base64) + "\"/>";
}

void SvgPlot::legend(const std::string& text, int series) { legend_.emplace_back(text, series); }

std::string SvgPlot::axes() const {
  const double right = width_ - room_right;
  const double bottom = height_ - room_bottom;
  std::string out;
  for (const Tick& tick : ticks_of(x_, (width_ - left()) / 90)) {
    const double x = to_x(tick.value);
    if (x_.categories.empty()) out += stroke(x, room_top, x, bottom, "plot-grid");
    out += text_at(x, bottom + 16, "middle", tick.text, "");
  }
  for (const Tick& tick : ticks_of(y_, (height_ - room_top - room_bottom) / 40)) {
    const double y = to_y(tick.value);
    if (y_.categories.empty()) out += stroke(left(), y, right, y, "plot-grid");
    out += text_at(left() - 6, y + 4, "end", tick.text, "");
  }
  out += text_at((left() + right) / 2, height_ - 8, "middle", x_.label, "");
  const std::string turned = attribute("transform", "rotate(-90 14 " + px((room_top + bottom) / 2) + ")");
  if (!y_.label.empty()) out += text_at(14, (room_top + bottom) / 2, "middle", y_.label, turned);
  return out;
}

std::string SvgPlot::svg() const {
  const double right = width_ - room_right;
  const double bottom = height_ - room_bottom;
  // Without a legend there is nothing above the axes.
  const int top = legend_.empty() ? room_top - 8 : 0;
  std::string out = "<svg class=\"plot\" role=\"img\" viewBox=\"0 " + std::to_string(top) + " " +
                    std::to_string(width_) + " " + std::to_string(height_ - top) + "\"" +
                    attribute("aria-label", html_text(title_)) + "><title>" + html_text(title_) + "</title>" + axes();
  // A nested picture cuts off what lies outside of the axes, and needs no name for that as a clip path does.
  out +=
      "<svg" + attribute("x", px(left())) + attribute("y", px(room_top)) + attribute("width", px(right - left())) +
      attribute("height", px(bottom - room_top)) +
      attribute("viewBox", px(left()) + " " + px(room_top) + " " + px(right - left()) + " " + px(bottom - room_top)) +
      ">" + content_ + "</svg>";
  out += stroke(left(), room_top, left(), bottom, "plot-axis") + stroke(left(), bottom, right, bottom, "plot-axis");
  double x = left();
  for (const auto& [text, series] : legend_) {
    out += "<rect" + attribute("class", "plot-fill " + series_class(series)) + attribute("x", px(x)) +
           " y=\"8\" width=\"12\" height=\"12\"/>" + text_at(x + 17, 18, "start", text, "");
    x += 17 + character_px * static_cast<double>(text.size()) + 18;
  }
  return out + "</svg>";
}

}  // namespace rigcal
