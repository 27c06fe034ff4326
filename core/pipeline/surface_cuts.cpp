#include "core/pipeline/surface_cuts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "core/base/parallel.h"
#include "core/quality/shared_surfaces.h"

namespace rigcal {
namespace {

constexpr std::size_t max_cuts = 3;
constexpr double half_length_m = 0.75;
constexpr double half_width_m = 0.15;
constexpr double least_half_depth_m = 0.05;
constexpr double most_half_depth_m = 0.75;
constexpr double apart_rad = to_rad(45.0);

// How much a leaf shows: who sees it counts first, then how well the one who sees least of it does.
struct Candidate {
  std::size_t feature = 0;
  std::size_t lidars = 0;
  double least_points = 0.0;
};

std::map<int, double> points_by_lidar(const PlaneFeature& feature) {
  std::map<int, double> points;
  for (const PlaneObservation& o : feature.observations) points[o.lidar] += o.N;
  return points;
}

std::vector<Candidate> candidates_of(const std::vector<PlaneFeature>& features) {
  std::vector<Candidate> out;
  for (std::size_t k = 0; k < features.size(); ++k) {
    if (features[k].merged) continue;
    const std::map<int, double> points = points_by_lidar(features[k]);
    if (points.size() < 2) continue;
    double least = points.begin()->second;
    for (const auto& [lidar, count] : points) least = std::min(least, count);
    out.push_back({k, points.size(), least});
  }
  std::stable_sort(out.begin(), out.end(), [](const Candidate& a, const Candidate& b) {
    return a.lidars != b.lidars ? a.lidars > b.lidars : a.least_points > b.least_points;
  });
  return out;
}

// A cut with the frame that its dots are in.
struct Window {
  Vector3d center = Vector3d::Zero();
  Vector3d normal = Vector3d::UnitZ();
  Vector3d along = Vector3d::UnitX();
  double half_depth_m = least_half_depth_m;
};

Window window_of(const PlaneFeature& feature, const Vector3d& normal, const RigState& before, const RigState& after) {
  Window window;
  window.normal = normal;
  double total = 0.0;
  for (const PlaneObservation& o : feature.observations) {
    window.center += o.N * (after.T_G_sensor(o.stop, o.lidar) * o.mean);
    total += o.N;
  }
  window.center /= total;
  // Level where the surface stands upright, whatever way it faces.
  const Vector3d level = normal.cross(Vector3d::UnitZ());
  window.along = level.norm() > 0.3 ? level.normalized() : normal.unitOrthogonal().eval();
  double farthest = 0.0;
  for (const PlaneObservation& o : feature.observations) {
    const Vector3d p = before.T_G_sensor(o.stop, o.lidar) * o.mean;
    farthest = std::max(farthest, std::abs(normal.dot(p - window.center)));
  }
  window.half_depth_m = std::clamp(1.3 * farthest, least_half_depth_m, most_half_depth_m);
  return window;
}

std::vector<Window> choose_windows(const std::vector<PlaneFeature>& features, const RigState& before,
                                   const RigState& after) {
  std::vector<Window> chosen;
  for (const Candidate& candidate : candidates_of(features)) {
    if (chosen.size() == max_cuts) break;
    const Vector3d normal = plane_normal(features[candidate.feature], after);
    const bool is_new = std::all_of(chosen.begin(), chosen.end(), [&](const Window& w) {
      return std::abs(w.normal.dot(normal)) < std::cos(apart_rad);
    });
    if (is_new) chosen.push_back(window_of(features[candidate.feature], normal, before, after));
  }
  return chosen;
}

using Dots = std::vector<SurfaceCut::Dot>;

// A window in the frame of a sensor: each point is taken once, as it was measured.
struct SensorWindow {
  Vector3d center;
  Vector3d normal;
  Vector3d along;
  Vector3d across;
  double half_depth_m;

  SensorWindow(const Window& window, const SE3& T_sensor_G)
      : center(T_sensor_G * window.center),
        normal(T_sensor_G.R * window.normal),
        along(T_sensor_G.R * window.along),
        across(T_sensor_G.R * window.normal.cross(window.along)),
        half_depth_m(window.half_depth_m) {}
};

// Appends to `dots`, a list for each window.
void collect(const PatchCells& patch, const SE3& T_G_sensor, std::uint8_t sensor, const std::vector<Window>& windows,
             std::vector<Dots>& dots) {
  const SE3 T_sensor_G = T_G_sensor.inverse();
  std::vector<SensorWindow> here;
  for (const Window& window : windows) here.emplace_back(window, T_sensor_G);
  for (const Point& point : patch.thinned) {
    for (std::size_t w = 0; w < here.size(); ++w) {
      const Vector3d d = Vector3d(point.x, point.y, point.z) - here[w].center;
      const double along = here[w].along.dot(d);
      if (std::abs(along) > half_length_m || std::abs(here[w].across.dot(d)) > half_width_m) continue;
      const double off = here[w].normal.dot(d);
      if (std::abs(off) > here[w].half_depth_m) continue;
      dots[w].push_back({static_cast<float>(along), static_cast<float>(off), sensor});
    }
  }
}

// Evenly fewer, so that no patch is preferred.
Dots thinned(const Dots& dots, std::size_t max_dots) {
  if (dots.size() <= max_dots) return dots;
  Dots kept;
  kept.reserve(max_dots);
  for (std::size_t i = 0; i < max_dots; ++i) kept.push_back(dots[i * dots.size() / max_dots]);
  return kept;
}

std::vector<Dots> all_dots(const std::vector<PatchCells>& patches, const RigState& state, const std::vector<char>& use,
                           const std::vector<int>& sensor_of, const std::vector<Window>& windows) {
  std::vector<std::vector<Dots>> of_patch(patches.size(), std::vector<Dots>(windows.size()));
  parallel_for(patches.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      if (!use[k]) continue;
      const auto sensor = static_cast<std::uint8_t>(sensor_of[static_cast<std::size_t>(patches[k].lidar)]);
      collect(patches[k], state.T_G_sensor(patches[k].stop, patches[k].lidar), sensor, windows, of_patch[k]);
    }
  });
  std::vector<Dots> out(windows.size());
  for (const std::vector<Dots>& patch : of_patch) {
    for (std::size_t w = 0; w < windows.size(); ++w) out[w].insert(out[w].end(), patch[w].begin(), patch[w].end());
  }
  return out;
}

}  // namespace

std::vector<SurfaceCut> cut_surfaces(const std::vector<PlaneFeature>& features, const std::vector<PatchCells>& patches,
                                     const RigState& before, const RigState& after, const std::vector<char>& use,
                                     const std::vector<int>& sensor_of, std::size_t max_dots) {
  const std::vector<Window> windows = choose_windows(features, before, after);
  const std::vector<Dots> dots_before = all_dots(patches, before, use, sensor_of, windows);
  const std::vector<Dots> dots_after = all_dots(patches, after, use, sensor_of, windows);
  std::vector<SurfaceCut> cuts;
  for (std::size_t w = 0; w < windows.size(); ++w) {
    if (dots_before[w].empty() || dots_after[w].empty()) continue;  // nothing to compare
    cuts.push_back({windows[w].center, windows[w].normal, half_length_m, windows[w].half_depth_m,
                    thinned(dots_before[w], max_dots), thinned(dots_after[w], max_dots)});
  }
  return cuts;
}

}  // namespace rigcal
