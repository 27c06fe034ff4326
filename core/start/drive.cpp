#include "core/start/drive.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/symmetric_solve.h"
#include "core/start/overlap_limits.h"
#include "core/start/own_view.h"
#include "core/start/surfel_index.h"

namespace rigcal {
namespace {

// How far the next stop may be, and a little more where nothing fits within that.
constexpr std::array<double, 2> reaches_m{1.5, 3.0};
constexpr double step_m = 0.3;
constexpr double fits_well = 0.4;
constexpr std::size_t searched_items = 150;
constexpr std::size_t refined = 8;
constexpr double apart_m = 0.4;
// A wall slid along itself fits as well, and better where that lays more of it on what was seen: a vehicle that goes on
// as it went is likelier. Beyond the first distance, so much of the score a metre; the first step is free.
constexpr double usual_m = 0.3;
constexpr double usual_first_m = 1.2;
constexpr double score_per_m = 0.4;

// A patch turned as the gyro says: only its place is open. Most of what a vehicle sees may be the ground it stands on;
// each direction of surfaces counts the same.
struct Turned {
  std::vector<PlacedSurfel> surfels;
  std::vector<double> weight;  // add up to 1
};

Turned turned(const PatchSurfels& patch, const Matrix3d& R, std::size_t count) {
  Turned out;
  const std::size_t items = std::min(count, patch.surfels.size());
  std::vector<Vector3d> normals;
  for (std::size_t i = 0; i < items; ++i) {
    const Surfel& s = patch.surfels[i * patch.surfels.size() / items];
    out.surfels.push_back({R * s.mean, R * s.normal, 0});
    normals.push_back(out.surfels.back().normal);
  }
  out.weight = balanced_weights(normals);
  return out;
}

double score_at(const SurfelIndex& map, const Turned& seen, const Vector3d& t, double cosine, double off_m) {
  double sum = 0.0;
  for (std::size_t i = 0; i < seen.surfels.size(); ++i) {
    const PlacedSurfel& s = seen.surfels[i];
    if (map.contains(s.mean + t, s.normal, cosine, off_m)) sum += seen.weight[i];
  }
  return sum;
}

struct Place {
  Vector3d t = Vector3d::Zero();
  double score = 0.0;
};

struct Expectation {
  Vector3d t = Vector3d::Zero();
  double within_m = 0.0;

  [[nodiscard]] double cost(const Vector3d& place) const {
    return score_per_m * std::max(0.0, (place - t).norm() - within_m);
  }
};

Place refined_place(const SurfelIndex& map, const Turned& seen, Place place) {
  for (double tolerance = 0.35; tolerance > 0.05; tolerance *= 0.85) {
    Matrix3d H = Matrix3d::Zero();
    Vector3d g = Vector3d::Zero();
    for (std::size_t i = 0; i < seen.surfels.size(); ++i) {
      const PlacedSurfel& s = seen.surfels[i];
      const Vector3d p = s.mean + place.t;
      const int hit = map.find(p, s.normal, same_surface_cosine, tolerance);
      if (hit < 0) continue;
      const Vector3d& n = map[hit].normal;
      const double r = n.dot(p - map[hit].mean);
      const double w = seen.weight[i] / (1.0 + 4.0 * r * r / (tolerance * tolerance));
      H += w * n * n.transpose();
      g += w * r * n;
    }
    // What nothing holds stays where it is.
    H.diagonal().array() += 1e-3;
    place.t -= solve_symmetric3(H, g);
  }
  place.score = score_at(map, seen, place.t, same_surface_cosine, same_surface_m);
  return place;
}

bool is_near(const Place& a, const Place& b) { return (a.t - b.t).norm() < apart_m; }

// Nothing where too little of the patch fits.
std::optional<Vector3d> find_place(const SurfelIndex& map, const PatchSurfels& patch, const Matrix3d& R,
                                   const Vector3d& around, const Expectation& expected) {
  const Turned few = turned(patch, R, searched_items);
  const Turned all = turned(patch, R, patch.surfels.size());
  std::optional<Place> best;
  double fit = 0.0;
  for (const double reach_m : reaches_m) {
    std::vector<Place> places;
    const auto n = static_cast<int>(std::floor(reach_m / step_m + 1e-9));
    for (int x = -n; x <= n; ++x)
      for (int y = -n; y <= n; ++y)
        for (int z = -n; z <= n; ++z) {
          const Vector3d shift = step_m * Vector3d(x, y, z);
          if (shift.norm() <= reach_m + 1e-9) places.push_back({around + shift, 0.0});
        }
    parallel_for(places.size(), 32, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        places[i].score = score_at(map, few, places[i].t, same_surface_cosine, 0.2) - expected.cost(places[i].t);
    });
    places = best_apart(std::move(places), refined, is_near);
    parallel_for(places.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        places[i] = refined_place(map, all, places[i]);
        places[i].score -= expected.cost(places[i].t);
      }
    });
    const Place found = best_apart(std::move(places), 1, is_near).front();
    if (!best || found.score > best->score) best = found;
    fit = best->score + expected.cost(best->t);
    if (fit >= fits_well) break;
  }
  if (fit < min_score) return std::nullopt;
  return best->t;
}

}  // namespace

std::vector<SE3> poses_of_drive(const std::vector<PatchSurfels>& base_patches, const std::vector<Matrix3d>& R_G_base) {
  std::vector<SE3> poses;
  std::vector<PlacedSurfel> map;
  std::size_t next = 0;
  SE3 last;                       // of the last patch,
  std::optional<SE3> last_moved;  // from the one before it
  for (std::size_t j = 0; j < R_G_base.size(); ++j) {
    SE3 T{R_G_base[j], poses.empty() ? Vector3d(Vector3d::Zero()) : poses.back().t};
    if (next < base_patches.size() && base_patches[next].stop == static_cast<int>(j)) {
      const PatchSurfels& patch = base_patches[next++];
      if (!map.empty()) {
        Expectation expected{T.t, usual_first_m};
        if (last_moved) expected = {last.t + last.R * last_moved->t, usual_m};
        T.t = find_place(SurfelIndex(map, 0.5), patch, T.R, T.t, expected).value_or(T.t);
        last_moved = last.inverse() * T;
      }
      last = T;
      for (const Surfel& s : patch.surfels) map.push_back({T * s.mean, T.R * s.normal, 0});
      // Whatever many stops have seen is kept once.
      map = without_repetitions(map, 0.25);
    }
    poses.push_back(T);
  }
  return poses;
}

}  // namespace rigcal
