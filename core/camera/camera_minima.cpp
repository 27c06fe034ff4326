#include "core/camera/camera_minima.h"

#include <algorithm>

namespace rigcal {
namespace {

// A minimum is clearly better where it explains so many times more.
constexpr double clearly_better = 1.1;

void sort_by_worth(std::vector<Minimum>& minima) {
  std::stable_sort(minima.begin(), minima.end(), [](const Minimum& a, const Minimum& b) { return a.worth > b.worth; });
}

}  // namespace

bool is_within(const SE3& a, const SE3& b, double rotation_rad, double translation_m) {
  const Vector6d apart = (a.inverse() * b).log();
  return apart.head<3>().norm() <= rotation_rad && apart.tail<3>().norm() <= translation_m;
}

bool is_same_minimum(const CameraState& a, const CameraState& b, double share) {
  return is_within(a.T_base_camera, b.T_base_camera, share * to_rad(0.2), share * 0.03);
}

Minima compare_minima(std::vector<Minimum>& minima) {
  sort_by_worth(minima);
  return compare_with(Minimum(minima.front()), minima);
}

Minima compare_with(const Minimum& end, std::vector<Minimum>& others) {
  sort_by_worth(others);
  Minima minima{end, std::nullopt, 0.0};
  for (const Minimum& other : others) {
    if (is_same_minimum(end.end.state, other.end.state, 1.0)) continue;
    minima.runner_up = other.end.state.T_base_camera;
    minima.runner_up_ratio = end.worth > 0.0 ? std::min(1.0, other.worth / end.worth) : 1.0;
    break;
  }
  return minima;
}

bool is_beaten(const Minimum& end, const std::vector<Minimum>& others) {
  return std::any_of(others.begin(), others.end(), [&](const Minimum& other) {
    return other.worth > clearly_better * end.worth && !is_same_minimum(other.end.state, end.end.state, 0.5);
  });
}

}  // namespace rigcal
