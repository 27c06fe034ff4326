#pragma once

#include <Eigen/Cholesky>
#include <algorithm>

#include "core/geometry/se3.h"

namespace rigcal {

struct PoseMinimum {
  SE3 T;
  double value = 0.0;
  int evaluations = 0;
};

struct PoseMinimizeOptions {
  int max_evaluations = 40;
  double shortest_step = 0.002;  ///< In the unit that `shape` makes: the root mean square change of the grey values.
};

/// The minimum near `start` of a smooth function of a pose, by BFGS. `evaluate(T)` returns `value`, its derivative
/// `gradient` by xi in T exp(xi), and `shape`, a positive matrix that tells which directions weigh how much.
template <class Evaluate>
[[nodiscard]] PoseMinimum minimize_pose(const SE3& start, const PoseMinimizeOptions& options,
                                        const Evaluate& evaluate) {
  constexpr double first_step = 0.5;
  constexpr double longest_step = 1.5;
  const auto here = evaluate(start);
  PoseMinimum best{start, here.value, 1};
  // In z = L^T xi all directions weigh the same.
  Matrix6d shape = here.shape;
  shape.diagonal() += 1e-4 * shape.diagonal();
  shape.diagonal().array() += 1e-12;
  const Eigen::LLT<Matrix6d> llt(shape);
  if (llt.info() != Eigen::Success) return best;
  const auto in_z = [&](const Vector6d& gradient) -> Vector6d { return llt.matrixL().solve(gradient); };
  const auto xi_of = [&](const Vector6d& z) -> Vector6d { return llt.matrixU().solve(z); };

  Vector6d g = in_z(here.gradient);
  Matrix6d H = Matrix6d::Identity() * (first_step / std::max(g.norm(), 1e-12));
  bool scaled = false;
  while (best.evaluations < options.max_evaluations) {
    Vector6d step = -(H * g);
    if (!(step.dot(g) < 0.0)) break;
    if (step.norm() > longest_step) step *= longest_step / step.norm();
    if (step.norm() < options.shortest_step) break;
    bool better = false;
    while (best.evaluations < options.max_evaluations && step.norm() >= 0.5 * options.shortest_step) {
      const SE3 T = best.T * SE3::exp(xi_of(step));
      const auto there = evaluate(T);
      ++best.evaluations;
      const Vector6d g_there = in_z(there.gradient);
      const Vector6d y = g_there - g;
      const double sy = step.dot(y);
      better = there.value < best.value + 1e-4 * g.dot(step);
      // What was learned of the curvature counts also where the step was too long.
      if (sy > 1e-3 * step.norm() * y.norm()) {
        if (!scaled) H = Matrix6d::Identity() * (sy / y.squaredNorm());
        scaled = true;
        const Matrix6d V = Matrix6d::Identity() - step * y.transpose() / sy;
        H = V * H * V.transpose() + step * step.transpose() / sy;
      }
      if (better) {
        best.T = T;
        best.value = there.value;
        g = g_there;
        break;
      }
      step *= 0.4;
    }
    if (!better) break;
  }
  return best;
}

}  // namespace rigcal
