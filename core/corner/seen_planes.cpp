#include "core/corner/seen_planes.h"

#include <algorithm>
#include <cmath>

#include "core/base/median.h"
#include "core/base/parallel.h"
#include "core/corner/plane_shares.h"
#include "core/corner/plane_votes.h"
#include "core/geometry/chi_square.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/patch_of_points.h"

namespace rigcal {
namespace {

constexpr std::size_t most_planes = 10;
constexpr double min_points = 30.0;
constexpr double min_area_m2 = 1.0;

constexpr int rounds = 6;  // of areas
constexpr int steps = 8;   // of weights with the same areas

// One step of `shared_out`; planes that lose their points are dropped. True: nothing moves any more.
bool refit(const std::vector<Vector3d>& points, std::vector<PlaneShare>& planes, std::vector<PlaneArea>& areas) {
  const std::vector<PlaneShare> fitted = shared_out(points, planes, areas);
  std::vector<PlaneShare> kept;
  std::vector<PlaneArea> kept_areas;
  bool rest = true;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (fitted[k].plane.points.N < min_points) continue;
    rest = rest && (fitted[k].plane.normal - planes[k].plane.normal).norm() < 1e-7 &&
           std::abs(fitted[k].plane.offset_m - planes[k].plane.offset_m) < 1e-6;
    kept.push_back(fitted[k]);
    kept_areas.push_back(std::move(areas[k]));
  }
  planes = std::move(kept);
  areas = std::move(kept_areas);
  return rest;
}

// Two that run into one another are one: the one with more points stays.
void drop_doubles(std::vector<PlaneShare>& planes) {
  std::stable_sort(planes.begin(), planes.end(),
                   [](const PlaneShare& a, const PlaneShare& b) { return a.plane.points.N > b.plane.points.N; });
  std::vector<PlaneShare> kept;
  for (const PlaneShare& w : planes) {
    const bool is_double = std::any_of(kept.begin(), kept.end(), [&](const PlaneShare& k) {
      return std::abs(k.plane.normal.dot(w.plane.normal)) > std::cos(to_rad(4.0)) &&
             std::abs(k.plane.distance(w.plane.points.mean())) < 3.0 * k.plane.sigma_m;
    });
    if (!is_double) kept.push_back(w);
  }
  planes = std::move(kept);
}

// By how much the parts of a plane stand off it beyond what the noise of their points explains.
void measure_unevenness(const std::vector<Vector3d>& points, const PlaneShare& w, const PlaneArea& area,
                        SeenPlane& out) {
  std::vector<double> sum(static_cast<std::size_t>(area.parts()), 0.0);
  std::vector<double> count(sum.size(), 0.0);
  for (const Vector3d& p : points) {
    const double d = w.plane.distance(p);
    const int part = area.part_of(p);
    if (part < 0 || std::abs(d) > 2.5 * w.plane.sigma_m) continue;
    sum[static_cast<std::size_t>(part)] += d;
    count[static_cast<std::size_t>(part)] += 1.0;
  }
  // The median part decides: at the borders other surfaces push.
  std::vector<double> squares;  // over what noise explains
  double total = 0.0;
  for (std::size_t k = 0; k < sum.size(); ++k) {
    if (count[k] < 3.0) continue;
    squares.push_back(sum[k] * sum[k] / (count[k] * w.plane.sigma_m * w.plane.sigma_m));
    total += count[k];
  }
  if (squares.empty()) return;
  out.points_per_part = total / static_cast<double>(squares.size());
  constexpr double chance = 1.6;
  const double ratio = median(std::move(squares)) / chi2_50_1;
  if (ratio < chance) return;
  out.unevenness_m = w.plane.sigma_m * std::sqrt((ratio - 1.0) / out.points_per_part);
}

std::vector<PlaneArea> areas_of(const std::vector<PlaneShare>& planes, const std::vector<Vector3d>& points,
                                double first_part_m) {
  std::vector<PlaneArea> areas;
  for (const PlaneShare& w : planes) {
    areas.emplace_back(w.plane, points, first_part_m > 0.0 ? first_part_m : part_size_m(w.plane.points));
  }
  return areas;
}

}  // namespace

PlaneCloud plane_cloud(std::span<const Vector3d> points) {
  return {{points.begin(), points.end()}, patch_of_points(points, 0, 0, CellOptions{})};
}

double SeenPlane::weight() const {
  return 1.0 / (plane.sigma_m * plane.sigma_m + points_per_part * unevenness_m * unevenness_m);
}

std::vector<SeenPlane> find_planes(const PlaneCloud& cloud) {
  const PlaneVotes votes = vote_for_planes(cloud.cells, most_planes);
  const double first_part_m = std::max(1.0, votes.surfel_m);
  std::vector<PlaneShare> planes;
  for (const FittedPlane& plane : votes.planes) {
    planes.push_back({plane});
    planes.back().plane.sigma_m = std::max(least_sigma_m, plane.sigma_m);
  }
  std::vector<PlaneArea> areas;
  for (int round = 0; round < rounds; ++round) {
    areas = areas_of(planes, cloud.points, round == 0 ? first_part_m : 0.0);
    bool rest = false;
    for (int step = 0; step < steps && !rest; ++step) rest = refit(cloud.points, planes, areas);
    const std::size_t before = planes.size();
    drop_doubles(planes);
    if (rest && before == planes.size() && round > 1) break;
  }
  areas = areas_of(planes, cloud.points, 0.0);
  std::vector<SeenPlane> out;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    if (areas[k].area_m2() < min_area_m2) continue;
    SeenPlane seen;
    seen.plane = planes[k].plane;
    seen.area_m2 = areas[k].area_m2();
    measure_unevenness(cloud.points, planes[k], areas[k], seen);
    out.push_back(seen);
  }
  return out;
}

}  // namespace rigcal
