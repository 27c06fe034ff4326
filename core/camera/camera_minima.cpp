#include "core/camera/camera_minima.h"

#include <algorithm>

namespace rigcal {

bool is_within(const SE3& a, const SE3& b, double rotation_rad, double translation_m) {
  const Vector6d apart = (a.inverse() * b).log();
  return apart.head<3>().norm() <= rotation_rad && apart.tail<3>().norm() <= translation_m;
}

bool is_same_minimum(const CameraState& a, const CameraState& b, double share) {
  return is_within(a.T_base_camera, b.T_base_camera, share * to_rad(0.2), share * 0.03);
}

Minima compare_minima(std::vector<EdgeSolution>& solutions) {
  std::stable_sort(solutions.begin(), solutions.end(),
                   [](const EdgeSolution& a, const EdgeSolution& b) { return a.score > b.score; });
  Minima minima;
  minima.best = solutions.front();
  for (const EdgeSolution& other : solutions) {
    if (is_same_minimum(minima.best.state, other.state, 1.0)) continue;
    minima.runner_up = other.state.T_base_camera;
    minima.runner_up_ratio = minima.best.score > 0.0 ? other.score / minima.best.score : 1.0;
    break;
  }
  return minima;
}

}  // namespace rigcal
