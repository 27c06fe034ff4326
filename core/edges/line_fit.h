#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <span>
#include <utility>

#include "core/edges/step_lines.h"

namespace rigcal {

/// Lays a line through its steps, whose means (c and inverse_depth) it has already: direction, ends and slope. `Step`
/// has u, v and inverse_depth. Which way the line goes is open. Returns the steps' scatter about c.
template <class Step>
Eigen::Matrix2d lay_through_steps(std::span<const Step> steps, StepLine& line) {
  const auto offset = [&](std::uint32_t i) {
    return Eigen::Vector2d(Eigen::Vector2d(steps[i].u, steps[i].v) - line.c);
  };
  Eigen::Matrix2d scatter = Eigen::Matrix2d::Zero();
  for (const std::uint32_t i : line.steps) {
    const Eigen::Vector2d d = offset(i);
    scatter += d * d.transpose();
  }
  const double angle = 0.5 * std::atan2(2.0 * scatter(0, 1), scatter(0, 0) - scatter(1, 1));
  line.t = {std::cos(angle), std::sin(angle)};
  double along2 = 0.0;
  for (const std::uint32_t i : line.steps) {
    const double s = line.t.dot(offset(i));
    line.low = std::min(line.low, s);
    line.high = std::max(line.high, s);
    line.slope += s * (steps[i].inverse_depth - line.inverse_depth);
    along2 += s * s;
  }
  line.slope = along2 > 0.0 ? line.slope / along2 : 0.0;
  return scatter;
}

/// The same line, gone along the other way.
inline void turn_around(StepLine& line) {
  line.t = -line.t;
  line.slope = -line.slope;
  std::swap(line.low, line.high);
  line.low = -line.low;
  line.high = -line.high;
}

}  // namespace rigcal
