#include "core/edges/row_lines.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "core/edges/line_fit.h"

namespace rigcal {
namespace {

constexpr double reach = 0.028;              // A line begins with steps so near to each other, in u and v: 1.6 degrees.
constexpr int least_rows = 5;                // It crosses so many,
constexpr double min_filled = 0.6;           // of those that lie between its ends this share,
constexpr double min_length = 0.010;         // and is so long, in u and v.
constexpr int most_missed = 3;               // It ends where so many rows in turn have no step on it.
constexpr double across_spacings = 0.65;     // Steps so near to a line belong to it.
constexpr double max_rms_spacings = 0.45;    // Of their distances across, in spacings.
constexpr double same_depth_m = 0.3;         // Steps of one line begin within this in depth,
constexpr double same_depth_per_m = 0.03;    // and so much for each metre;
constexpr double painted_depth_per_m = 0.3;  // painted ones lie on a road that goes away.

using Eigen::Vector2d;

// More neighbours tell no more of where a line through one of them goes.
constexpr std::size_t most_neighbours = 80;

// Rounds of fitting a line to what lies on it, and of looking what lies on it.
constexpr int most_rounds = 8;

class RowLineGrower {
 public:
  explicit RowLineGrower(std::span<const RowStep> steps) : steps_(steps), used_(steps.size(), 0) { fill_grid(); }

  [[nodiscard]] std::vector<StepLine> run() {
    std::vector<std::pair<int, std::uint32_t>> seeds;
    for (std::uint32_t i = 0; i < steps_.size(); ++i) {
      const int rows = rows_of(straightest(i));
      if (rows >= least_rows - 1) seeds.emplace_back(-rows, i);
    }
    std::sort(seeds.begin(), seeds.end());
    std::vector<StepLine> lines;
    for (const auto& [rows, seed] : seeds) {
      if (used_[seed]) continue;
      StepLine line = grown(seed);
      if (!is_line(line)) continue;
      for (const std::uint32_t i : line.steps) used_[i] = 1;
      lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  [[nodiscard]] int column(double x) const {
    return std::clamp(static_cast<int>((x + 1.0) * 0.5 * columns_), 0, columns_ - 1);
  }

  void fill_grid() {
    columns_ = std::clamp(static_cast<int>(2.0 / reach), 1, 1000);
    cells_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(columns_));
    for (std::uint32_t i = 0; i < steps_.size(); ++i)
      cells_[static_cast<std::size_t>(column(steps_[i].v) * columns_ + column(steps_[i].u))].push_back(i);
  }

  template <class Visit>
  void visit_box(const Vector2d& low, const Vector2d& high, const Visit& visit) const {
    for (int y = column(low.y()); y <= column(high.y()); ++y) {
      for (int x = column(low.x()); x <= column(high.x()); ++x) {
        for (const std::uint32_t i : cells_[static_cast<std::size_t>(y * columns_ + x)]) {
          if (!used_[i]) visit(i);
        }
      }
    }
  }

  [[nodiscard]] Vector2d at(std::uint32_t i) const { return {steps_[i].u, steps_[i].v}; }

  [[nodiscard]] double depth_gate_m(const RowStep& step) const {
    return same_depth_m + same_depth_per_m / step.inverse_depth;
  }

  // Steps like one around it, in other rows, the nearest first.
  [[nodiscard]] std::vector<std::uint32_t> alike(std::uint32_t seed) const {
    const RowStep& s = steps_[seed];
    const double depth = 1.0 / s.inverse_depth;
    const double gate = s.is_painted() ? painted_depth_per_m * depth : depth_gate_m(s);
    std::vector<std::pair<double, std::uint32_t>> found;
    visit_box(at(seed).array() - reach, at(seed).array() + reach, [&](std::uint32_t i) {
      const RowStep& other = steps_[i];
      if (other.change != s.change || other.row == s.row) return;
      const double apart = (at(i) - at(seed)).norm();
      if (apart > reach || std::abs(1.0 / other.inverse_depth - depth) > gate) return;
      found.emplace_back(apart, i);
    });
    std::sort(found.begin(), found.end());
    if (found.size() > most_neighbours) found.resize(most_neighbours);
    std::vector<std::uint32_t> out;
    for (const auto& [apart, i] : found) out.push_back(i);
    return out;
  }

  [[nodiscard]] int rows_of(const std::vector<std::uint32_t>& members) const {
    std::vector<int> rows;
    for (const std::uint32_t i : members) rows.push_back(steps_[i].row);
    std::sort(rows.begin(), rows.end());
    return static_cast<int>(std::unique(rows.begin(), rows.end()) - rows.begin());
  }

  // One step and those around it that lie on a line with it: of the lines through it and another one that with most
  // rows.
  [[nodiscard]] std::vector<std::uint32_t> straightest(std::uint32_t seed) const {
    const std::vector<std::uint32_t> around = alike(seed);
    const double across = across_spacings * steps_[seed].spacing;
    std::vector<std::uint32_t> best;
    int best_rows = 0;
    std::vector<std::uint32_t> on;
    for (const std::uint32_t through : around) {
      const Vector2d t = (at(through) - at(seed)).normalized();
      on.assign(1, seed);
      for (const std::uint32_t i : around) {
        const Vector2d d = at(i) - at(seed);
        if (std::abs(t.x() * d.y() - t.y() * d.x()) <= across) on.push_back(i);
      }
      if (static_cast<int>(on.size()) <= best_rows) continue;
      const int rows = rows_of(on);
      if (rows <= best_rows) continue;
      best_rows = rows;
      best = on;
    }
    return best;
  }

  [[nodiscard]] StepLine fitted(std::vector<std::uint32_t> members) const {
    StepLine line;
    line.steps = std::move(members);
    line.painted = steps_[line.steps.front()].is_painted();
    const double share = 1.0 / static_cast<double>(line.steps.size());
    Vector2d towards = Vector2d::Zero();
    for (const std::uint32_t i : line.steps) {
      line.c += share * at(i);
      line.spacing += share * steps_[i].spacing;
      line.inverse_depth += share * steps_[i].inverse_depth;
      towards += steps_[i].towards;
    }
    const Eigen::Matrix2d scatter = lay_through_steps(steps_, line);
    if (line.n().dot(towards) < 0.0) turn_around(line);
    line.rms = std::sqrt(std::max(0.0, share * line.n().dot(scatter * line.n())));
    // Steps lie anywhere between two returns.
    line.shift = std::max(line.rms, 0.3 * line.spacing) * std::sqrt(share);
    return line;
  }

  // What lies on a line and on its surface, from a row of it to both sides up to where too many rows have nothing.
  [[nodiscard]] std::vector<std::uint32_t> members(const StepLine& line, std::uint32_t seed) const {
    const double low = line.low - reach;
    const double high = line.high + reach;
    const double across = across_spacings * line.spacing;
    const Vector2d a = line.c + low * line.t;
    const Vector2d b = line.c + high * line.t;
    std::vector<std::pair<int, std::uint32_t>> on;
    visit_box(a.cwiseMin(b).array() - across, a.cwiseMax(b).array() + across, [&](std::uint32_t i) {
      if (steps_[i].change != steps_[seed].change) return;
      const Vector2d d = at(i) - line.c;
      const double s = line.t.dot(d);
      const double inverse_depth = line.inverse_depth + line.slope * s;
      if (s < low || s > high || std::abs(line.n().dot(d)) > across || inverse_depth <= 0.0) return;
      if (std::abs(1.0 / steps_[i].inverse_depth - 1.0 / inverse_depth) > depth_gate_m(steps_[i])) return;
      on.emplace_back(steps_[i].row, i);
    });
    std::sort(on.begin(), on.end());
    auto begin = std::lower_bound(on.begin(), on.end(), std::pair<int, std::uint32_t>{steps_[seed].row, 0});
    auto end = begin;
    const int most_apart = most_missed + 1;
    for (int last = steps_[seed].row; end != on.end() && end->first - last <= most_apart; ++end) last = end->first;
    for (int last = steps_[seed].row; begin != on.begin() && last - std::prev(begin)->first <= most_apart; --begin)
      last = std::prev(begin)->first;
    std::vector<std::uint32_t> out;
    for (auto it = begin; it != end; ++it) out.push_back(it->second);
    return out;
  }

  [[nodiscard]] StepLine grown(std::uint32_t seed) const {
    std::vector<std::uint32_t> on = straightest(seed);
    StepLine line;
    for (int round = 0; round < most_rounds && on.size() > 2 && on != line.steps; ++round) {
      line = fitted(std::move(on));
      on = members(line, seed);
    }
    return line;
  }

  [[nodiscard]] bool is_line(const StepLine& line) const {
    if (line.steps.size() < 3) return false;
    int first = steps_[line.steps.front()].row;
    int last = first;
    for (const std::uint32_t i : line.steps) {
      first = std::min(first, steps_[i].row);
      last = std::max(last, steps_[i].row);
    }
    const int rows = rows_of(line.steps);
    return rows >= least_rows && rows >= min_filled * (last - first + 1) && line.high - line.low >= min_length &&
           line.rms <= max_rms_spacings * line.spacing;
  }

  std::span<const RowStep> steps_;
  std::vector<char> used_;
  int columns_ = 1;
  std::vector<std::vector<std::uint32_t>> cells_;
};

}  // namespace

std::vector<StepLine> find_row_lines(std::span<const RowStep> steps) { return RowLineGrower(steps).run(); }

}  // namespace rigcal
