#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/camera/information.h"
#include "core/camera/information_chance.h"
#include "core/camera/information_cost.h"
#include "core/camera/information_images.h"
#include "core/camera/minimize_pose.h"

namespace rigcal {
namespace {

// What a guess that is off by one sigma counts, in units of the information distance. Without it flat costs end metres
// away, where hardly anything overlaps.
constexpr double prior_weight = 0.001;

constexpr double grid_step_rad = to_rad(2.0);
// A pixel of the images by which the grid is searched: the cost must be smooth over a step.
constexpr double grid_pixel_rad = to_rad(0.5);
constexpr std::size_t grid_sightings = 30'000;
constexpr std::size_t grid_occluders = 250'000;

// So many minima of the grid are refined,
constexpr std::size_t refined_minima = 5;
// and those that end as near to each other as this are one.
constexpr double same_rad = to_rad(1.0);
constexpr double same_m = 0.15;

// A best place hardly better than any says nothing.
constexpr double min_depth = 0.002;

class Prior {
 public:
  Prior(const SE3& guess, const CameraCalibrationOptions& options)
      : guess_(guess), per_rad_(1.0 / options.guess_sigma_rad), per_m_(1.0 / options.guess_sigma_m) {}

  [[nodiscard]] double value(const SE3& T) const {
    return prior_weight *
           (std::pow(per_rad_ * rotation_distance(T.R, guess_.R), 2) + std::pow(per_m_ * (T.t - guess_.t).norm(), 2));
  }
  [[nodiscard]] Vector6d gradient(const SE3& T) const {
    Vector6d g;
    g << per_rad_ * per_rad_ * log_so3(guess_.R.transpose() * T.R),
        per_m_ * per_m_ * (T.R.transpose() * (T.t - guess_.t));
    return 2.0 * prior_weight * g;
  }

 private:
  SE3 guess_;
  double per_rad_;
  double per_m_;
};

struct GridPoint {
  SE3 T;
  double score = 0.0;
  double seen = 0.0;
};

std::vector<GridPoint> rotations_around(const SE3& guess, double radius_rad) {
  const int n = std::max(1, static_cast<int>(std::floor(radius_rad / grid_step_rad + 1e-9)));
  std::vector<GridPoint> grid;
  for (int x = -n; x <= n; ++x) {
    for (int y = -n; y <= n; ++y) {
      for (int z = -n; z <= n; ++z) {
        if (x * x + y * y + z * z > n * n) continue;
        grid.push_back({{guess.R * exp_so3(grid_step_rad * Vector3d(x, y, z)), guess.t}, 0.0, 0.0});
      }
    }
  }
  return grid;
}

void score_grid(const InformationCost& cost, const Prior& prior, const InformationChance& chance,
                std::vector<GridPoint>& grid) {
  parallel_for(grid.size(), 2, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) {
      const InformationCost::Value value = cost.value(grid[k].T);
      grid[k].score = value.distance + prior.value(grid[k].T) + chance.gain(value.seen);
      grid[k].seen = value.seen;
    }
  });
  std::stable_sort(grid.begin(), grid.end(), [](const GridPoint& a, const GridPoint& b) { return a.score < b.score; });
}

InformationPose refined(const InformationCost& cost, const Prior& prior, const InformationChance& chance,
                        const SE3& start, int evaluations) {
  PoseMinimizeOptions options;
  options.max_evaluations = evaluations;
  options.shortest_step = 0.02;
  const PoseMinimum minimum = minimize_pose(start, options, [&](const SE3& T) {
    InformationCost::Derivatives d = cost.derivatives(T);
    d.value += prior.value(T);
    d.gradient += prior.gradient(T);
    return d;
  });
  return {minimum.T, minimum.value + chance.gain(cost.value(minimum.T).seen)};
}

bool same_place(const SE3& a, const SE3& b) {
  return rotation_distance(a.R, b.R) < same_rad && (a.t - b.t).norm() < same_m;
}

// The minima that the best points of a sorted grid lead to, best first.
std::vector<InformationPose> minima_of(const std::vector<GridPoint>& grid, const InformationCost& cost,
                                       const Prior& prior, const InformationChance& chance) {
  std::vector<SE3> starts;
  for (const GridPoint& point : grid) {
    if (starts.size() == refined_minima) break;
    const bool near_other = std::any_of(starts.begin(), starts.end(), [&](const SE3& T) {
      return rotation_distance(T.R, point.T.R) < 1.5 * grid_step_rad;
    });
    if (!near_other) starts.push_back(point.T);
  }
  std::vector<InformationPose> ends(starts.size());
  parallel_for(starts.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) ends[k] = refined(cost, prior, chance, starts[k], 15);
  });
  std::stable_sort(ends.begin(), ends.end(),
                   [](const InformationPose& a, const InformationPose& b) { return a.distance < b.distance; });
  std::vector<InformationPose> minima;
  for (const InformationPose& end : ends) {
    const bool known = std::any_of(minima.begin(), minima.end(), [&](const InformationPose& m) {
      return same_place(m.T_base_camera, end.T_base_camera);
    });
    if (!known) minima.push_back(end);
  }
  return minima;
}

}  // namespace

std::optional<InformationSearch> search_information(const CameraScene& scene, const CameraTask& camera,
                                                    const SE3& guess_T_base_camera,
                                                    const CameraCalibrationOptions& options,
                                                    const RunContext& context) {
  const SurfaceCodes codes = surface_codes(scene.samples);
  const CameraModel model(camera.intrinsics);
  // What hides what depends on where the camera is, not on where it looks: found once for all rotations.
  SightingOptions wanted;
  wanted.max_samples = grid_occluders;
  wanted.max_sightings = grid_sightings;
  wanted.silhouette_cells = 1;
  const CameraModel wide = widened(model, options.guess_sigma_rad + to_rad(1.0), 3.0);
  const std::vector<Sighting> sightings = find_sightings(scene, codes, camera, wide, guess_T_base_camera, wanted);
  if (sightings.empty()) return std::nullopt;

  const double focal_px = 0.5 * (camera.intrinsics.fx + camera.intrinsics.fy);
  const int halvings = std::clamp(static_cast<int>(std::lround(std::log2(focal_px * grid_pixel_rad))), 0, 8);
  const std::vector<SmoothImage> blurred = information_images(scene, camera, halvings, Shown::brightness);
  const InformationCost cost(model, sightings, blurred);
  const Prior prior(guess_T_base_camera, options);
  std::vector<GridPoint> grid = rotations_around(guess_T_base_camera, options.guess_sigma_rad);
  const InformationChance chance(sightings);
  score_grid(cost, prior, chance, grid);
  if (context.cancelled() || grid.front().seen < InformationCost::kLeastSeen) return std::nullopt;
  if (grid[grid.size() / 2].score - grid.front().score < min_depth) return std::nullopt;

  std::vector<InformationPose> minima = minima_of(grid, cost, prior, chance);
  minima.resize(std::min<std::size_t>(2, minima.size()));
  const std::vector<SmoothImage> sharper =
      information_images(scene, camera, std::max(0, halvings - 1), Shown::brightness);
  const InformationCost sharp(model, sightings, sharper);
  for (InformationPose& m : minima) m = refined(sharp, prior, chance, m.T_base_camera, 20);
  if (context.cancelled()) return std::nullopt;
  std::stable_sort(minima.begin(), minima.end(),
                   [](const InformationPose& a, const InformationPose& b) { return a.distance < b.distance; });
  InformationSearch search;
  search.best = minima.front();
  if (minima.size() > 1 && !same_place(minima[0].T_base_camera, minima[1].T_base_camera)) search.runner_up = minima[1];
  return search;
}

}  // namespace rigcal
