#include "core/edges/row_steps.h"

#include <algorithm>
#include <cmath>

namespace rigcal {
namespace {

constexpr double min_rise_m = 0.4;       // The far surface is so much farther,
constexpr double min_rise_per_m = 0.05;  // and so much for each metre of range.
constexpr double goes_on_m = 0.3;        // The near surface goes on to the other side within this.
// Returns so far apart, in steps of their row, have others missing between them:
constexpr double neighbour_steps = 3.0;
constexpr double gap_steps = 5.0;            // nothing came back there, if it is so far.
constexpr double farthest_gap_m = 60.0;      // Beyond, surfaces hardly give returns anyway.
constexpr int painted_returns = 2;           // Reflectivities are means of so many on either side,
constexpr double painted_contrast = 1.5;     // their difference over the root of their sum, which is how they scatter,
constexpr double painted_even_m = 0.25;      // and ranges so even,
constexpr double painted_even_per_m = 0.02;  // and so much less for each metre.

class RowReader {
 public:
  RowReader(const ScanRow& row, int number, std::array<std::vector<RowStep>, cube_faces>& out)
      : points_(row.points), step_rad_(row.step_rad), number_(number), out_(out) {
    if (row.closed) close();
  }

  void run() {
    for (std::size_t i = lap_; i + 1 < points_.size() && i + lap_ < points_.size(); ++i) look_between(i);
    find_paint();
  }

 private:
  // What comes past either end, so that nothing is missed there.
  void close() {
    lap_ = std::min(points_.size(), static_cast<std::size_t>(painted_returns) + 1);
    const auto lap = static_cast<std::ptrdiff_t>(lap_);
    std::vector<RowPoint> before(points_.end() - lap, points_.end());
    std::vector<RowPoint> after(points_.begin(), points_.begin() + lap);
    for (RowPoint& p : before) p.azimuth_rad -= static_cast<float>(2.0 * pi);
    for (RowPoint& p : after) p.azimuth_rad += static_cast<float>(2.0 * pi);
    points_.insert(points_.begin(), before.begin(), before.end());
    points_.insert(points_.end(), after.begin(), after.end());
  }

  [[nodiscard]] double apart(std::size_t i) const {
    return static_cast<double>(points_[i + 1].azimuth_rad - points_[i].azimuth_rad);
  }
  [[nodiscard]] double range(std::size_t i) const { return static_cast<double>(points_[i].range_m); }

  // Whether the surface of a return goes on away from another one beside it: a return alone is a stray one.
  [[nodiscard]] bool goes_on(std::size_t i, bool to_higher) const {
    if (to_higher ? i + 1 >= points_.size() : i == 0) return false;
    const std::size_t other = to_higher ? i + 1 : i - 1;
    return apart(std::min(i, other)) < neighbour_steps * step_rad_ && std::abs(range(other) - range(i)) < goes_on_m;
  }

  void look_between(std::size_t i) {
    const double angle = apart(i);
    if (angle > gap_steps * step_rad_) {
      if (range(i) < farthest_gap_m && goes_on(i, false)) add(i, 0.5 * step_rad_, RowChange::ends_before_farther);
      if (range(i + 1) < farthest_gap_m && goes_on(i + 1, true)) add(i + 1, -0.5 * step_rad_, RowChange::begins);
      return;
    }
    if (angle > neighbour_steps * step_rad_) return;
    const double rise = range(i + 1) - range(i);
    const double least = std::max(min_rise_m, min_rise_per_m * std::min(range(i), range(i + 1)));
    if (rise > least && goes_on(i, false)) add(i, 0.5 * angle, RowChange::ends_before_farther);
    if (-rise > least && goes_on(i + 1, true)) add(i + 1, -0.5 * angle, RowChange::begins);
  }

  // A return's place, turned along the row.
  void add(std::size_t i, double by_rad, RowChange change) {
    const double azimuth = static_cast<double>(points_[i].azimuth_rad) + by_rad;
    const auto elevation = static_cast<double>(points_[i].elevation_rad);
    const double level = range(i) * std::cos(elevation);
    const Vector3d p(level * std::cos(azimuth), level * std::sin(azimuth), range(i) * std::sin(elevation));
    const FacePlace at = to_face(p);
    // The row's tangent as the face shows it.
    const Vector3d tangent = p + Vector3d(-p.y(), p.x(), 0.0) * step_rad_;
    const int axis = at.face / 2;
    const double depth = std::abs(tangent[axis]);
    const Eigen::Vector2d step(tangent[(axis + 1) % 3] / depth - at.u, tangent[(axis + 2) % 3] / depth - at.v);
    const bool forwards = change == RowChange::ends_before_farther || change == RowChange::gets_brighter;
    out_[static_cast<std::size_t>(at.face)].push_back(
        {at.u, at.v, at.inverse_depth, step.norm(), (forwards ? 1.0 : -1.0) * step.normalized(), number_, change});
  }

  // Between the returns i - 1 and i; 0 where they are not of one surface.
  [[nodiscard]] double contrast(std::size_t i) const {
    const auto side = static_cast<std::size_t>(painted_returns);
    const std::size_t begin = i - side;
    const std::size_t end = i + side;
    if (static_cast<double>(points_[end - 1].azimuth_rad - points_[begin].azimuth_rad) >
        neighbour_steps * painted_returns * step_rad_) {
      return 0.0;
    }
    double low = range(begin);
    double high = low;
    double before = 0.0;
    double after = 0.0;
    for (std::size_t k = begin; k < end; ++k) {
      low = std::min(low, range(k));
      high = std::max(high, range(k));
      (k < i ? before : after) += static_cast<double>(points_[k].reflectivity) / painted_returns;
    }
    if (high - low > painted_even_m + painted_even_per_m * range(i)) return 0.0;
    return (after - before) / (std::sqrt(before + after) + 2.0);  // 2: what the darkest scatter by
  }

  void find_paint() {
    const auto side = static_cast<std::size_t>(painted_returns);
    if (points_.size() < 2 * side + 2) return;
    std::vector<double> contrasts(points_.size(), 0.0);
    for (std::size_t i = side; i + side <= points_.size(); ++i) contrasts[i] = contrast(i);
    for (std::size_t i = std::max(side, lap_); i + std::max(side, lap_) < points_.size(); ++i) {
      const double size = std::abs(contrasts[i]);
      // Where it is largest.
      if (size < painted_contrast || size < std::abs(contrasts[i - 1]) || size <= std::abs(contrasts[i + 1])) continue;
      add(i - 1, 0.5 * apart(i - 1), contrasts[i] > 0.0 ? RowChange::gets_brighter : RowChange::gets_darker);
    }
  }

  std::vector<RowPoint> points_;
  std::size_t lap_ = 0;  // so many of them come again at either end
  double step_rad_;
  int number_;
  std::array<std::vector<RowStep>, cube_faces>& out_;
};

}  // namespace

std::array<std::vector<RowStep>, cube_faces> find_row_steps(std::span<const ScanRow> rows) {
  std::array<std::vector<RowStep>, cube_faces> steps;
  for (std::size_t k = 0; k < rows.size(); ++k) RowReader(rows[k], static_cast<int>(k), steps).run();
  return steps;
}

}  // namespace rigcal
