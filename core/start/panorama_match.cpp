#include "core/start/panorama_match.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/angles.h"
#include "core/start/registration.h"

namespace rigcal {
namespace {

constexpr double yaw_step_rad = to_rad(1.0);
constexpr double yaw_apart_rad = to_rad(8.0);
constexpr std::size_t yaws = 6;
constexpr double height_step_m = 0.05;
constexpr double height_reach_m = 2.0;
constexpr double height_apart_m = 0.2;
constexpr std::size_t heights_each = 4;
constexpr std::size_t enough_lying = 10;
constexpr std::size_t items = 600;
// All places are tried with few, the best share of them with all.
constexpr std::size_t first_items = 200;
constexpr std::size_t best_share = 4;

// z along the axis, origin at its foot.
SE3 T_frame_axis(const AxisTurn& turn) {
  Matrix3d R;
  R.col(2) = turn.axis;
  R.col(0) = turn.axis.unitOrthogonal();
  R.col(1) = turn.axis.cross(R.col(0));
  return {R, turn.foot};
}

std::vector<PlacedSurfel> about_axis(const Panorama& panorama) {
  const SE3 T = T_frame_axis(panorama.turn).inverse();
  std::vector<PlacedSurfel> out;
  for (const PlacedSurfel& s : panorama.surfels) out.push_back({T * s.mean, T.R * s.normal, 0});
  return out;
}

// The plan of what stands upright.
std::vector<PlacedSurfel> flattened(const std::vector<PlacedSurfel>& surfels) {
  std::vector<PlacedSurfel> out;
  for (const PlacedSurfel& s : surfels) {
    if (std::abs(s.normal.z()) > 0.4) continue;
    const Vector3d n(s.normal.x(), s.normal.y(), 0.0);
    out.push_back({Vector3d(s.mean.x(), s.mean.y(), 0.0), n.normalized(), 0});
  }
  return out;
}

// What tells a height: upright walls meet at any.
std::vector<PlacedSurfel> lying(const std::vector<PlacedSurfel>& surfels) {
  std::vector<PlacedSurfel> out;
  for (const PlacedSurfel& s : surfels) {
    if (std::abs(s.normal.z()) > 0.4) out.push_back(s);
  }
  return out;
}

MovingSurfels moving_of(const std::vector<PlacedSurfel>& surfels) {
  MovingSurfels moving{{SE3{}}, {}};
  for (const PlacedSurfel& s : surfels) moving.items.push_back({0, s.mean, s.normal});
  return thinned(moving, items);
}

struct Peak {
  double at = 0.0;
  double score = 0.0;
};

SE3 about(double yaw, double height) { return {exp_so3(yaw * Vector3d::UnitZ()), height * Vector3d::UnitZ()}; }

// Scores of `line`, of which only those that may be peaks are left.
template <class Place>
std::vector<Peak> scored(std::vector<Peak> line, const SurfelIndex& index, const MovingSurfels& moving, double reach_m,
                         const Place& place) {
  const double cosine = std::cos(to_rad(15.0));
  const MovingSurfels few = thinned(moving, first_items);
  for (Peak& p : line) p.score = balanced_score(index, few, place(p.at), cosine, reach_m);
  std::stable_sort(line.begin(), line.end(), [](const Peak& a, const Peak& b) { return a.score > b.score; });
  line.resize(line.size() / best_share);
  for (Peak& p : line) p.score = balanced_score(index, moving, place(p.at), cosine, reach_m);
  return line;
}

std::vector<Peak> yaw_peaks(const std::vector<PlacedSurfel>& map, const std::vector<PlacedSurfel>& other) {
  const SurfelIndex index(without_repetitions(flattened(map), 0.5), 1.0);
  const MovingSurfels moving = moving_of(without_repetitions(flattened(other), 0.5));
  std::vector<Peak> circle(static_cast<std::size_t>(std::lround(2.0 * pi / yaw_step_rad)));
  for (std::size_t k = 0; k < circle.size(); ++k) circle[k].at = static_cast<double>(k) * yaw_step_rad;
  circle = scored(std::move(circle), index, moving, 0.2, [](double yaw) { return about(yaw, 0.0); });
  return best_apart(std::move(circle), yaws,
                    [](const Peak& a, const Peak& b) { return angle_apart(a.at, b.at) <= yaw_apart_rad; });
}

std::vector<Peak> height_peaks(const SurfelIndex& index, const MovingSurfels& moving, double yaw) {
  const auto steps = static_cast<int>(std::lround(height_reach_m / height_step_m));
  std::vector<Peak> line;
  for (int k = -steps; k <= steps; ++k) line.push_back({k * height_step_m, 0.0});
  line = scored(std::move(line), index, moving, 0.1, [&](double height) { return about(yaw, height); });
  return best_apart(std::move(line), heights_each,
                    [](const Peak& a, const Peak& b) { return std::abs(a.at - b.at) <= height_apart_m; });
}

}  // namespace

Panorama make_panorama(const AxisTurn& turn, const std::vector<PatchSurfels>& patches,
                       const std::vector<SE3>& T_zero_this) {
  Panorama out{turn, {}};
  for (const PatchSurfels& p : patches) {
    const SE3& T = T_zero_this[static_cast<std::size_t>(p.stop)];
    for (const Surfel& s : p.surfels) out.surfels.push_back({T * s.mean, T.R * s.normal, p.stop});
  }
  return out;
}

std::vector<SE3> match_panoramas(const Panorama& map, const Panorama& other) {
  const std::vector<PlacedSurfel> here = about_axis(map);
  const std::vector<PlacedSurfel> there = about_axis(other);
  std::vector<PlacedSurfel> fixed = lying(without_repetitions(here, 0.5));
  std::vector<PlacedSurfel> moved = lying(without_repetitions(there, 0.5));
  if (std::min(fixed.size(), moved.size()) < enough_lying) {
    // Then the ends of what stands upright may.
    fixed = without_repetitions(here, 0.5);
    moved = without_repetitions(there, 0.5);
  }
  const SurfelIndex index(std::move(fixed), 0.6);
  const MovingSurfels moving = moving_of(moved);
  const SE3 T_map = T_frame_axis(map.turn);
  const SE3 T_other = T_frame_axis(other.turn).inverse();
  std::vector<Peak> peaks = yaw_peaks(here, there);
  std::vector<std::pair<double, SE3>> found;
  std::vector<std::vector<Peak>> heights(peaks.size());
  parallel_for(peaks.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) heights[k] = height_peaks(index, moving, peaks[k].at);
  });
  for (std::size_t k = 0; k < peaks.size(); ++k) {
    for (const Peak& h : heights[k]) found.emplace_back(h.score, T_map * about(peaks[k].at, h.at) * T_other);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<SE3> out;
  for (const auto& [score, T] : found) out.push_back(T);
  return out;
}

}  // namespace rigcal
