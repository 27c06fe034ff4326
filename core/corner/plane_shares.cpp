#include "core/corner/plane_shares.h"

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/geometry/symmetric_eigen.h"

namespace rigcal {
namespace {

constexpr double slab_sigmas = 6.0;
constexpr std::size_t chunk = 4096;

double density(const PlaneShare& w, double d) {
  const double u = d / w.plane.sigma_m;
  return w.share * std::exp(-0.5 * u * u) / (w.plane.sigma_m * std::sqrt(2.0 * pi));
}

double stray_density(const PlaneShare& w) { return (1.0 - w.share) / (2.0 * slab_sigmas * w.plane.sigma_m); }

struct Sums {
  std::vector<PointCluster> points;
  std::vector<double> squares;
  std::vector<double> not_on_others;

  explicit Sums(std::size_t planes = 0) : points(planes), squares(planes, 0.0), not_on_others(planes, 0.0) {}
  Sums& operator+=(const Sums& other) {
    for (std::size_t k = 0; k < points.size(); ++k) {
      points[k] += other.points[k];
      squares[k] += other.squares[k];
      not_on_others[k] += other.not_on_others[k];
    }
    return *this;
  }
};

// A plane that a point may lie on.
struct Chance {
  std::size_t plane = 0;
  double distance = 0.0;
  double likely = 0.0;
};

// Adds the point to the sums of all planes that it may lie on.
void share_out(const Vector3d& p, const std::vector<PlaneShare>& planes, const std::vector<PlaneArea>& areas,
               std::vector<Chance>& chances, Sums& sums) {
  chances.clear();
  double all = 0.0;
  double stray = 0.0;
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const double d = planes[k].plane.distance(p);
    if (std::abs(d) > slab_sigmas * planes[k].plane.sigma_m || areas[k].part_of(p) < 0) continue;
    chances.push_back({k, d, density(planes[k], d)});
    all += chances.back().likely;
    stray = std::max(stray, stray_density(planes[k]));
  }
  for (const Chance& c : chances) {
    const double sure = c.likely / std::max(all, 1e-300);
    const double w = sure * c.likely / (all + stray);
    PointCluster one;
    one.add(p);
    sums.points[c.plane] += one.scaled(w);
    sums.squares[c.plane] += w * c.distance * c.distance;
    sums.not_on_others[c.plane] += w + stray / (all + stray);
  }
}

}  // namespace

std::vector<PlaneShare> shared_out(const std::vector<Vector3d>& points, const std::vector<PlaneShare>& planes,
                                   const std::vector<PlaneArea>& areas) {
  const Sums sums = parallel_sum(points.size(), chunk, Sums(planes.size()), [&](std::size_t begin, std::size_t end) {
    Sums part(planes.size());
    std::vector<Chance> chances;
    for (std::size_t i = begin; i < end; ++i) share_out(points[i], planes, areas, chances, part);
    return part;
  });
  std::vector<PlaneShare> out(planes.size());
  for (std::size_t k = 0; k < planes.size(); ++k) {
    const auto fitted = fit_plane(sums.points[k]);
    if (!fitted) continue;
    out[k].plane = *fitted;
    out[k].plane.sigma_m = std::max(least_sigma_m, std::sqrt(sums.squares[k] / sums.points[k].N));
    out[k].share = std::clamp(sums.points[k].N / sums.not_on_others[k], 0.05, 0.999);
  }
  return out;
}

double part_size_m(const PointCluster& points) {
  constexpr double points_a_part = 15.0;
  const Vector3d spread = symmetric_eigen(points.covariance()).values;
  const double area_m2 = 12.0 * std::sqrt(spread[1] * spread[2]);  // of an even rectangle
  return std::clamp(std::sqrt(points_a_part * area_m2 / points.N), 0.5, 3.0);
}

}  // namespace rigcal
