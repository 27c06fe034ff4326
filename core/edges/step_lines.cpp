#include "core/edges/step_lines.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>

#include "core/base/median.h"
#include "core/base/wide.h"
#include "core/edges/line_fit.h"

namespace rigcal {
namespace {

constexpr double min_angle_rad = to_rad(1.0);  // Shorter ones are chance; seen from the sensor.
constexpr double min_length_m = 1.0;           // And shorter ones are leaves.
constexpr int min_steps = 15;                  // So many rays end there.
constexpr double min_filled = 0.5;             // Share of its length at which they do.
constexpr double max_gap_spacings = 10.0;
constexpr double across_spacings = 0.9;    // Steps so near to a line belong to it.
constexpr double max_rms_spacings = 0.55;  // Of the steps' distances across, in spacings.
constexpr double max_depth_rms_m = 0.13;   // And in depth: leaves scatter more.
constexpr double min_rise_m = 0.25;        // Median: a floor seen flat has rows of small steps.

// How far surfaces are thick where they end: noise and mixed points.
constexpr double thickness_m = 0.06;

// Scans are denser along their own lines than across: a row may have a step in every third spacing only.
constexpr double seed_spacings = 10.0;
constexpr double filled_spacings = 3.0;

constexpr std::uint32_t seed_every = 3;  // an outline has many more steps

// What is asked of steps is kept in the order of the cells: u, v, towards the far side in u and v, inverse depth.
constexpr std::size_t sorted_values = 5;
using SortedSteps = std::array<const float*, sorted_values>;

// Steps on the same side of the same surface.
struct Alike {
  float u;
  float v;
  float towards_u;
  float towards_v;
  float inverse_depth;
  float reach2;
  float depth_gate;
};

RIGCAL_WIDE void mark_alike(const SortedSteps& steps, std::uint32_t count, const Alike& wanted,
                            std::int32_t* __restrict marks) {
  const SortedSteps of = steps;
  const Alike at = wanted;
  for (std::uint32_t i = 0; i < count; ++i) {
    const float du = of[0][i] - at.u;
    const float dv = of[1][i] - at.v;
    const float same_way = of[2][i] * at.towards_u + of[3][i] * at.towards_v;
    const float deeper = std::abs(of[4][i] - at.inverse_depth);
    marks[i] = static_cast<std::int32_t>(du * du + dv * dv <= at.reach2) & static_cast<std::int32_t>(same_way >= 0.2F) &
               static_cast<std::int32_t>(deeper <= at.depth_gate);
  }
}

// What lies on a line and on its near surface, but for rounding.
struct OnLine {
  float cu;
  float cv;
  float tu;
  float tv;
  float low;
  float high;
  float across;
  float towards_u;
  float towards_v;
  float inverse_depth;
  float slope;
};

RIGCAL_WIDE void mark_on(const SortedSteps& steps, std::uint32_t count, const OnLine& line,
                         std::int32_t* __restrict marks) {
  const SortedSteps of = steps;
  const OnLine at = line;
  constexpr auto thick = static_cast<float>(thickness_m);
  for (std::uint32_t i = 0; i < count; ++i) {
    const float du = of[0][i] - at.cu;
    const float dv = of[1][i] - at.cv;
    const float s = at.tu * du + at.tv * dv;
    const float off = std::abs(at.tu * dv - at.tv * du);
    const float same_way = of[2][i] * at.towards_u + of[3][i] * at.towards_v;
    const float w = std::abs(at.inverse_depth + at.slope * s);
    const float deeper = std::abs(of[4][i] - at.inverse_depth - at.slope * s);
    marks[i] = static_cast<std::int32_t>(s >= at.low) & static_cast<std::int32_t>(s <= at.high) &
               static_cast<std::int32_t>(off <= at.across) & static_cast<std::int32_t>(same_way >= 0.3F) &
               static_cast<std::int32_t>(deeper <= 0.01F * w + thick * w * w);
  }
}

class LineGrower {
 public:
  LineGrower(int face, const std::vector<DepthStep>& steps, const BeamWidth& beam)
      : face_(face), steps_(steps), beam_(beam) {
    used_.assign(steps.size(), 0);
    fill_grid();
  }

  [[nodiscard]] std::vector<StepLine> run() {
    std::vector<StepLine> lines;
    std::vector<char> tried(steps_.size(), 0);
    for (const std::uint32_t seed : seeds()) {
      if (used_[seed] || tried[seed]) continue;
      StepLine line = grown(seed);
      const bool good = is_outline(line);
      // What grew from one step of a row grows from the next one too.
      std::vector<char>& done = good ? used_ : tried;
      done[seed] = 1;
      for (const std::uint32_t i : line.steps) done[i] = 1;
      if (good) lines.push_back(std::move(line));
    }
    return lines;
  }

 private:
  static constexpr int columns = 200;

  [[nodiscard]] static int column(double x) {
    return std::clamp(static_cast<int>((x + 1.0) * 0.5 * columns), 0, columns - 1);
  }

  void fill_grid() {
    starts_.assign(static_cast<std::size_t>(columns) * columns + 1, 0);
    const auto cell = [](const DepthStep& s) {
      return static_cast<std::size_t>(column(s.v)) * columns + static_cast<std::size_t>(column(s.u));
    };
    for (const DepthStep& s : steps_) ++starts_[cell(s) + 1];
    for (std::size_t i = 1; i < starts_.size(); ++i) starts_[i] += starts_[i - 1];
    order_.resize(steps_.size());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    for (std::uint32_t i = 0; i < steps_.size(); ++i) order_[next[cell(steps_[i])]++] = i;
    for (std::vector<float>& values : sorted_) values.reserve(steps_.size());
    for (const std::uint32_t i : order_) {
      const DepthStep& s = steps_[i];
      const std::array<float, sorted_values> values{s.u, s.v, s.towards_u, s.towards_v, s.inverse_depth};
      for (std::size_t k = 0; k < sorted_values; ++k) sorted_[k].push_back(values[k]);
    }
    std::uint32_t longest = 0;
    for (std::size_t row = 0; row < columns; ++row)
      longest = std::max(longest, starts_[(row + 1) * columns] - starts_[row * columns]);
    marks_.resize(longest);
  }

  [[nodiscard]] SortedSteps sorted_from(std::uint32_t begin) const {
    SortedSteps steps;
    for (std::size_t k = 0; k < sorted_values; ++k) steps[k] = sorted_[k].data() + begin;
    return steps;
  }

  // Calls `visit(begin, end)` for the places in `order_` of each row of a box.
  template <class Visit>
  void rows_within(const Eigen::Vector2d& low, const Eigen::Vector2d& high, const Visit& visit) const {
    for (int y = column(low.y()); y <= column(high.y()); ++y) row_within(y, low.x(), high.x(), visit);
  }

  template <class Visit>
  void row_within(int y, double low, double high, const Visit& visit) const {
    const auto row = static_cast<std::size_t>(y) * columns;
    const std::uint32_t begin = starts_[row + static_cast<std::size_t>(column(low))];
    const std::uint32_t end = starts_[row + static_cast<std::size_t>(column(high)) + 1];
    if (begin < end) visit(begin, end);
  }

  // The same for a strip to either side of a stretch of a line: hardly more than what lies on it, however slanted.
  template <class Visit>
  void rows_along(const StepLine& line, double low, double high, double across, const Visit& visit) const {
    const double v_low = line.c.y() + std::min(low * line.t.y(), high * line.t.y()) - across;
    const double v_high = line.c.y() + std::max(low * line.t.y(), high * line.t.y()) + across;
    for (int y = column(v_low); y <= column(v_high); ++y) {
      // Where the line is while the strip is in this row; steps beyond the face's border are in its last rows.
      double first = low;
      double last = high;
      if (y > 0 && y < columns - 1 && std::abs(line.t.y()) > 1e-6) {
        const double top = (2.0 * y / columns - 1.0 - across - line.c.y()) / line.t.y();
        const double bottom = (2.0 * (y + 1) / columns - 1.0 + across - line.c.y()) / line.t.y();
        first = std::max(low, std::min(top, bottom));
        last = std::min(high, std::max(top, bottom));
        if (first > last) continue;
      }
      const double u_first = line.c.x() + first * line.t.x();
      const double u_last = line.c.x() + last * line.t.x();
      row_within(y, std::min(u_first, u_last) - across, std::max(u_first, u_last) + across, visit);
    }
  }

  [[nodiscard]] Eigen::Vector2d at(std::uint32_t i) const { return {steps_[i].u, steps_[i].v}; }
  [[nodiscard]] static double depth_gate(double inverse_depth) {
    return 0.01 * inverse_depth + thickness_m * inverse_depth * inverse_depth;
  }

  // Steps on the same side of the same surface around one.
  [[nodiscard]] std::vector<std::uint32_t> neighbours(std::uint32_t seed) {
    const DepthStep& s = steps_[seed];
    const double reach = seed_spacings * s.spacing;
    const Alike wanted{s.u,
                       s.v,
                       s.towards_u,
                       s.towards_v,
                       s.inverse_depth,
                       static_cast<float>(reach * reach),
                       static_cast<float>(2.0 * depth_gate(s.inverse_depth))};
    std::vector<std::uint32_t> found;
    rows_within(at(seed).array() - reach, at(seed).array() + reach, [&](std::uint32_t begin, std::uint32_t end) {
      mark_alike(sorted_from(begin), end - begin, wanted, marks_.data());
      for (std::uint32_t k = begin; k < end; ++k) {
        if (marks_[k - begin] != 0 && !used_[order_[k]]) found.push_back(order_[k]);
      }
    });
    return found;
  }

  // Places whose surroundings look straight, the straightest first.
  [[nodiscard]] std::vector<std::uint32_t> seeds() {
    std::vector<std::pair<double, std::uint32_t>> scored;
    for (std::uint32_t i = 0; i < steps_.size(); i += seed_every) {
      const auto around = neighbours(i);
      if (around.size() < 6) continue;
      const StepLine line = fitted(around);
      if (line.rms > max_rms(line) || line.high - line.low < 5.0 * line.spacing) continue;
      scored.emplace_back(-(line.high - line.low) / std::max(line.rms, 0.1 * line.spacing), i);
    }
    std::sort(scored.begin(), scored.end());
    std::vector<std::uint32_t> out;
    for (const auto& [score, i] : scored) out.push_back(i);
    return out;
  }

  [[nodiscard]] StepLine fitted(std::vector<std::uint32_t> members) const {
    StepLine line;
    line.steps = std::move(members);
    const double share = 1.0 / static_cast<double>(line.steps.size());
    for (const std::uint32_t i : line.steps) {
      line.c += at(i);
      line.spacing += steps_[i].spacing;
      line.inverse_depth += steps_[i].inverse_depth;
    }
    line.c *= share;
    line.spacing *= share;
    line.inverse_depth *= share;
    const Eigen::Matrix2d scatter = lay_through_steps(std::span(steps_), line);
    const Eigen::Vector2d n = line.n();
    line.rms = std::sqrt(std::max(0.0, share * (n.x() * n.x() * scatter(0, 0) + 2.0 * n.x() * n.y() * scatter(0, 1) +
                                                n.y() * n.y() * scatter(1, 1))));
    return line;
  }

  // What lies on the line, in the stretch around its middle that is not broken.
  [[nodiscard]] std::vector<std::uint32_t> members(const StepLine& line, const Eigen::Vector2d& towards) {
    const double beyond = 2.0 * seed_spacings * line.spacing;
    const double across = across_spacings * line.spacing + 0.5 * half_beam(face_, line.c, line.n(), beam_);
    const double low = line.low - beyond;
    const double high = line.high + beyond;
    const auto f = [](double value) { return static_cast<float>(value); };
    const OnLine wanted{f(line.c.x()), f(line.c.y()),  f(line.t.x()),  f(line.t.y()),         f(low),       f(high),
                        f(across),     f(towards.x()), f(towards.y()), f(line.inverse_depth), f(line.slope)};
    std::vector<std::pair<double, std::uint32_t>> on;
    rows_along(line, low, high, across, [&](std::uint32_t begin, std::uint32_t end) {
      mark_on(sorted_from(begin), end - begin, wanted, marks_.data());
      for (std::uint32_t k = begin; k < end; ++k) {
        if (marks_[k - begin] != 0 && !used_[order_[k]]) on.emplace_back(line.t.dot(at(order_[k]) - line.c), order_[k]);
      }
    });
    std::sort(on.begin(), on.end());
    // From the middle outwards up to the first gap.
    const double gap = max_gap_spacings * line.spacing;
    auto begin = std::lower_bound(on.begin(), on.end(), std::pair<double, std::uint32_t>{0.0, 0});
    auto end = begin;
    double last = 0.0;
    while (end != on.end() && end->first - last < gap) last = (end++)->first;
    last = 0.0;
    while (begin != on.begin() && last - std::prev(begin)->first < gap) last = (--begin)->first;
    std::vector<std::uint32_t> out;
    for (auto it = begin; it != end; ++it) out.push_back(it->second);
    return out;
  }

  [[nodiscard]] StepLine grown(std::uint32_t seed) {
    StepLine line = fitted(neighbours(seed));
    Eigen::Vector2d towards = line.n();
    if (towards.dot(Eigen::Vector2d(steps_[seed].towards_u, steps_[seed].towards_v)) < 0.0) towards = -towards;
    for (int round = 0; round < 16; ++round) {
      std::vector<std::uint32_t> on = members(line, towards);
      if (on.size() < 5) break;
      const bool still = on == line.steps;
      line = fitted(std::move(on));
      if (line.n().dot(towards) < 0.0) turn_around(line);
      towards = line.n();
      if (still) break;
    }
    return line;
  }

  [[nodiscard]] bool is_outline(const StepLine& line) const {
    const double length = line.high - line.low;
    return static_cast<int>(line.steps.size()) >= min_steps && length >= min_length_m * line.inverse_depth &&
           length >= min_angle_rad && line.rms <= max_rms(line) && filled(line) >= min_filled &&
           depth_rms_m(line) <= max_depth_rms_m && median_rise_m(line) >= min_rise_m;
  }

  // Steps scatter by the distance of the rays and by how much of the beam still meets the surface.
  [[nodiscard]] double max_rms(const StepLine& line) const {
    return max_rms_spacings * line.spacing + 0.3 * half_beam(face_, line.c, line.n(), beam_);
  }

  // How far the near surface's points lie in depth from the line: leaves and grass scatter.
  [[nodiscard]] double depth_rms_m(const StepLine& line) const {
    std::vector<double> off;
    for (const std::uint32_t i : line.steps) {
      const double w = line.inverse_depth + line.slope * line.t.dot(at(i) - line.c);
      off.push_back(std::abs((steps_[i].inverse_depth - w) / (w * w)));
    }
    return sigma_per_median_size * median(std::move(off));
  }

  [[nodiscard]] double median_rise_m(const StepLine& line) const {
    std::vector<float> rises;
    for (const std::uint32_t i : line.steps) rises.push_back(steps_[i].rise_m);
    return static_cast<double>(median(std::move(rises)));
  }

  [[nodiscard]] double filled(const StepLine& line) const {
    const double stretch = filled_spacings * line.spacing;
    std::vector<char> hit(static_cast<std::size_t>((line.high - line.low) / stretch) + 1, 0);
    for (const std::uint32_t i : line.steps) {
      const double s = (line.t.dot(at(i) - line.c) - line.low) / stretch;
      hit[std::min(hit.size() - 1, static_cast<std::size_t>(std::max(0.0, s)))] = 1;
    }
    return std::accumulate(hit.begin(), hit.end(), 0.0) / static_cast<double>(hit.size());
  }

  int face_;
  const std::vector<DepthStep>& steps_;
  const BeamWidth& beam_;
  std::vector<char> used_;
  std::vector<std::uint32_t> starts_;
  std::vector<std::uint32_t> order_;  // steps by cells
  std::array<std::vector<float>, sorted_values> sorted_;
  std::vector<std::int32_t> marks_;
};

}  // namespace

std::vector<StepLine> find_step_lines(int face, const std::vector<DepthStep>& steps, const BeamWidth& beam) {
  return LineGrower(face, steps, beam).run();
}

double half_beam(int face, const Eigen::Vector2d& at, const Eigen::Vector2d& n, const BeamWidth& beam) {
  const Vector3d d = from_face({face, at.x(), at.y(), 1.0});
  const Vector3d ray = d.normalized();
  Vector3d across = from_face({face, at.x() + n.x(), at.y() + n.y(), 1.0}) - d;
  across -= ray.dot(across) * ray;
  const double angle_per_step = across.norm() / d.norm();
  across.normalize();
  const Vector3d level = Vector3d::UnitZ().cross(ray);
  const double share = level.norm() > 0.01 ? across.dot(level.normalized()) : 0.0;
  const double width =
      std::hypot(beam.level_rad * share, beam.upright_rad * std::sqrt(std::max(0.0, 1.0 - share * share)));
  return 0.5 * width / angle_per_step;
}

}  // namespace rigcal
