#include "core/edges/scan_rows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "core/base/median.h"
#include "core/geometry/se3.h"

namespace rigcal {
namespace {

// Rows are told apart where elevations between them are empty: this fine, and each no wider than so many steps. The
// nearest rows of common LiDARs are a tenth of a degree apart.
constexpr double elevation_step_rad = to_rad(0.01);
constexpr int most_steps_wide = 6;

// Few rows, or rows that hold few of the points, are chance.
constexpr std::size_t least_rows = 8;
constexpr std::size_t least_of_row = 50;
constexpr double least_share = 0.8;

// So much of a turn without a return in any row was not recorded.
constexpr int turn_bins = 360;
constexpr int least_empty_bins = 4;

constexpr float nearest_m = 0.5F;  // what is nearer is the vehicle, or no return at all

std::vector<RowPoint> seen(std::span<const Point> points) {
  std::vector<RowPoint> out;
  out.reserve(points.size());
  for (const Point& p : points) {
    const float level = std::hypot(p.x, p.y);
    const float range = std::hypot(level, p.z);
    if (!(range > nearest_m) || !std::isfinite(range)) continue;
    out.push_back({std::atan2(p.y, p.x), std::atan2(p.z, level), range, p.reflectivity});
  }
  return out;
}

// Where the recorded sector begins; none where the whole turn was recorded.
std::optional<float> begin_of_sector(const std::vector<ScanRow>& rows) {
  std::array<bool, turn_bins> filled{};
  const auto bin_of = [](float azimuth_rad) {
    return static_cast<std::size_t>((static_cast<double>(azimuth_rad) / (2.0 * pi) + 0.5) * turn_bins) % turn_bins;
  };
  for (const ScanRow& row : rows) {
    for (const RowPoint& p : row.points) filled[bin_of(p.azimuth_rad)] = true;
  }
  int longest = 0;
  int end_of_longest = 0;
  int empty = 0;
  // Twice around: the longest one may go on past where the numbers begin.
  for (int k = 0; k < 2 * turn_bins; ++k) {
    empty = filled[static_cast<std::size_t>(k % turn_bins)] ? 0 : empty + 1;
    if (empty <= longest) continue;
    longest = empty;
    end_of_longest = (k + 1) % turn_bins;
  }
  if (longest < least_empty_bins) return {};
  return static_cast<float>((static_cast<double>(end_of_longest) / turn_bins - 0.5) * 2.0 * pi);
}

double median_step(const std::vector<RowPoint>& row) {
  std::vector<float> steps;
  for (std::size_t i = 1; i < row.size(); ++i) steps.push_back(row[i].azimuth_rad - row[i - 1].azimuth_rad);
  return static_cast<double>(median(std::move(steps)));
}

}  // namespace

std::vector<ScanRow> find_scan_rows(std::span<const Point> points) {
  std::vector<RowPoint> all = seen(points);
  constexpr auto steps = static_cast<std::size_t>(pi / elevation_step_rad) + 2;
  const auto step_of = [](const RowPoint& p) {
    const double at = (static_cast<double>(p.elevation_rad) + 0.5 * pi) / elevation_step_rad;
    return std::min(steps - 1, static_cast<std::size_t>(std::max(0.0, at)));
  };
  std::vector<std::uint32_t> count(steps + 1, 0);
  for (const RowPoint& p : all) ++count[step_of(p)];
  constexpr std::int32_t none = -1;
  std::vector<std::int32_t> row_of(steps, none);
  std::vector<ScanRow> rows;
  std::size_t in_rows = 0;
  for (std::size_t begin = 0; begin < steps; ++begin) {
    std::size_t end = begin;
    std::size_t sum = 0;
    while (count[end] > 0) sum += count[end++];
    if (sum >= least_of_row && end - begin <= most_steps_wide) {
      std::fill(row_of.begin() + static_cast<std::ptrdiff_t>(begin), row_of.begin() + static_cast<std::ptrdiff_t>(end),
                static_cast<std::int32_t>(rows.size()));
      rows.emplace_back().points.reserve(sum);
      in_rows += sum;
    }
    begin = std::max(begin, end);
  }
  if (rows.size() < least_rows || static_cast<double>(in_rows) < least_share * static_cast<double>(all.size()))
    return {};
  for (const RowPoint& p : all) {
    const std::int32_t row = row_of[step_of(p)];
    if (row != none) rows[static_cast<std::size_t>(row)].points.push_back(p);
  }
  const std::optional<float> begin = begin_of_sector(rows);
  for (ScanRow& row : rows) {
    row.closed = !begin;
    for (RowPoint& p : row.points) {
      if (begin && p.azimuth_rad < *begin) p.azimuth_rad += static_cast<float>(2.0 * pi);
    }
    std::stable_sort(row.points.begin(), row.points.end(),
                     [](const RowPoint& a, const RowPoint& b) { return a.azimuth_rad < b.azimuth_rad; });
    row.step_rad = median_step(row.points);
  }
  return rows;
}

}  // namespace rigcal
