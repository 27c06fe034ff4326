#include "core/corner/ransac_planes.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr double confidence = 0.9999;  // To have drawn three points of the best plane at least once.
// Draws are compared by so many of the points, evenly over the cloud.
constexpr std::size_t scored_points = 4000;
constexpr int refits = 12;

std::optional<FittedPlane> plane_through(const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  PointCluster three;
  three.add(a);
  three.add(b);
  three.add(c);
  return fit_plane(three);
}

std::size_t count_near(const FittedPlane& plane, std::span<const Vector3d> points, double threshold_m) {
  return static_cast<std::size_t>(std::count_if(
      points.begin(), points.end(), [&](const Vector3d& p) { return std::abs(plane.distance(p)) <= threshold_m; }));
}

// How many draws make it sure that three of a share `inliers` came together.
double draws_for(double inliers) {
  const double all_three = std::pow(inliers, 3);
  if (all_three >= 1.0) return 1.0;
  return all_three <= 0.0 ? 1e9 : std::log(1.0 - confidence) / std::log(1.0 - all_three);
}

std::optional<FittedPlane> best_drawn(std::span<const Vector3d> points, const RansacOptions& options, Random& random) {
  std::vector<Vector3d> few;
  const std::size_t size = std::min(points.size(), scored_points);
  for (std::size_t i = 0; i < size; ++i) few.push_back(points[i * points.size() / size]);
  std::optional<FittedPlane> best;
  std::size_t most = 0;
  double needed = options.max_draws;
  for (int draw = 0; draw < std::min<double>(needed, options.max_draws); ++draw) {
    const std::uint64_t a = random.below(points.size());
    const std::uint64_t b = random.below(points.size());
    const std::uint64_t c = random.below(points.size());
    const auto plane = plane_through(points[a], points[b], points[c]);
    if (!plane) continue;
    const std::size_t near = count_near(*plane, few, options.threshold_m);
    if (near <= most) continue;
    most = near;
    best = plane;
    needed = draws_for(static_cast<double>(near) / static_cast<double>(size));
  }
  return best;
}

std::optional<FittedPlane> refitted(FittedPlane plane, std::span<const Vector3d> points, const RansacOptions& options) {
  double before = 0.0;
  for (int k = 0; k < refits; ++k) {
    PointCluster near;
    for (const Vector3d& p : points) {
      if (std::abs(plane.distance(p)) <= options.threshold_m) near.add(p);
    }
    const auto fitted = fit_plane(near);
    if (!fitted) return std::nullopt;
    const bool same = near.N == before && (fitted->normal - plane.normal).norm() < 1e-12;
    before = near.N;
    plane = *fitted;
    if (same) break;
  }
  return plane;
}

}  // namespace

std::vector<FittedPlane> ransac_planes(std::span<const Vector3d> points, const RansacOptions& options) {
  std::vector<FittedPlane> planes;
  std::vector<Vector3d> left(points.begin(), points.end());
  Random random(options.seed);
  const double least = std::max(3.0, options.min_share * static_cast<double>(points.size()));
  while (planes.size() < options.planes && static_cast<double>(left.size()) >= least) {
    const auto drawn = best_drawn(left, options, random);
    if (!drawn) break;
    const auto plane = refitted(*drawn, left, options);
    if (!plane || plane->points.N < least) break;
    planes.push_back(*plane);
    std::erase_if(left, [&](const Vector3d& p) { return std::abs(plane->distance(p)) <= options.threshold_m; });
  }
  return planes;
}

}  // namespace rigcal
