#include "core/start/registration.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/matrix6.h"
#include "core/start/coarse_search.h"
#include "core/start/own_view.h"

namespace rigcal {
namespace {

// Of candidates that were tried with few surfels, so many with more, and of these so many with most.
constexpr std::size_t contenders = 10;
constexpr std::size_t finalists = 3;
// The nearest surfel decides, not any of the many around, one of which is tilted enough to pass through anywhere.
constexpr double nearest_reach = 5.0;
// A step this small beside the tolerance changes no partner any more.
constexpr double settled_share = 1e-3;
// A guess may be wrong by so much about each axis (16 degrees), searched in such steps (4 degrees),
constexpr double rotation_reach_rad = 0.28;
constexpr double rotation_step_rad = 0.07;
// and at 0 and +- this along each axis; the index reaches between.
constexpr double translation_reach_m = 0.4;
constexpr std::size_t refined = 6;  // of these poses, the best
// A place near a guess is left only for one that fits this much better.
constexpr double clearly_better = 1.3;

using Candidate = ScoredPose;

void sort_by_score(std::vector<Candidate>& candidates) {
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.score > b.score; });
}

// The first of them, and the first that is distinctly another.
RegistrationResult result_of(const std::vector<Candidate>& sorted) {
  RegistrationResult result;
  if (sorted.empty()) return result;
  result.X = sorted[0].X;
  result.score = sorted[0].score;
  for (const Candidate& c : sorted) {
    if (!distinct(c.X, result.X)) continue;
    result.runner_up = c.X;
    result.runner_up_score = c.score;
    break;
  }
  return result;
}

bool is_near(const SE3& a, const SE3& b) {
  return rotation_distance(a.R, b.R) < 1.1 * rotation_step_rad && (a.t - b.t).norm() < 0.3;
}

}  // namespace

std::vector<SE3> search_grid(const SE3& guess) {
  std::vector<SE3> out;
  const int n = static_cast<int>(std::lround(rotation_reach_rad / rotation_step_rad));
  std::vector<Vector3d> shifts{Vector3d::Zero()};
  for (int axis = 0; axis < 3; ++axis)
    for (const double sign : {-1.0, 1.0}) shifts.push_back(sign * translation_reach_m * Vector3d::Unit(axis));
  for (int a = -n; a <= n; ++a)
    for (int b = -n; b <= n; ++b)
      for (int c = -n; c <= n; ++c) {
        const Vector3d phi = rotation_step_rad * Vector3d(a, b, c);
        // The corners of the cube lie farther out than the reach along an axis: a ball will do.
        if (phi.norm() > rotation_reach_rad * 1.2 + 1e-9) continue;
        for (const Vector3d& shift : shifts) out.push_back({guess.R * exp_so3(phi), guess.t + shift});
      }
  return out;
}

MovingSurfels thinned(const MovingSurfels& moving, std::size_t count) {
  if (moving.items.size() <= count) return moving;
  MovingSurfels out{moving.places, {}};
  const double step = static_cast<double>(moving.items.size()) / static_cast<double>(count);
  for (std::size_t i = 0; i < count; ++i)
    out.items.push_back(moving.items[static_cast<std::size_t>(static_cast<double>(i) * step)]);
  return out;
}

double match_score(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X, double min_cosine,
                   double max_plane_distance_m) {
  if (moving.items.empty()) return 0.0;
  const std::vector<SE3> placed = placed_by(moving, X);
  std::size_t matched = 0;
  for (const auto& item : moving.items) {
    const SE3& T = placed[static_cast<std::size_t>(item.place)];
    if (index.contains(T * item.mean, T.R * item.normal, min_cosine, max_plane_distance_m)) ++matched;
  }
  return static_cast<double>(matched) / static_cast<double>(moving.items.size());
}

double balanced_score(const SurfelIndex& index, const MovingSurfels& moving, const SE3& X, double min_cosine,
                      double max_plane_distance_m) {
  if (moving.items.empty()) return 0.0;
  std::vector<Vector3d> normals;
  normals.reserve(moving.items.size());
  std::vector<char> matched;
  matched.reserve(moving.items.size());
  const std::vector<SE3> placed = placed_by(moving, X);
  for (const auto& item : moving.items) {
    const SE3& T = placed[static_cast<std::size_t>(item.place)];
    normals.push_back(T.R * item.normal);
    const Vector3d p = T * item.mean;
    const int hit = index.find(p, normals.back(), min_cosine, nearest_reach * max_plane_distance_m);
    const bool meets = hit >= 0 && std::abs(index[hit].normal.dot(p - index[hit].mean)) <= max_plane_distance_m;
    matched.push_back(meets ? 1 : 0);
  }
  const std::vector<double> weights = balanced_weights(normals);
  double score = 0.0;
  for (std::size_t k = 0; k < weights.size(); ++k) score += matched[k] ? weights[k] : 0.0;
  return score;
}

SE3 refine_registration(const SurfelIndex& index, const MovingSurfels& moving, const SE3& start, double from_m,
                        double to_m, double pull) {
  SE3 X = start;
  double tolerance = from_m;
  for (int iteration = 0; iteration < 24; ++iteration) {
    // Normals may disagree by 26 degrees at a metre, by 10 at the end.
    const double min_cosine = std::cos(to_rad(std::clamp(10.0 + 16.0 * tolerance, 10.0, 30.0)));
    Matrix6d H = Matrix6d::Zero();
    Vector6d g = Vector6d::Zero();
    const std::vector<SE3> placed = placed_by(moving, X);
    for (const auto& item : moving.items) {
      const SE3& T = placed[static_cast<std::size_t>(item.place)];
      const Vector3d p = T * item.mean;
      const int hit = index.find(p, T.R * item.normal, min_cosine, tolerance);
      if (hit < 0) continue;
      const PlacedSurfel& s = index[hit];
      const double r = s.normal.dot(p - s.mean);
      // d p / d xi of A X exp(xi) m: R [-[m]x, I].
      const Vector3d n = T.R.transpose() * s.normal;
      Vector6d J;
      J << item.mean.cross(n), n;
      const double w = 1.0 / (1.0 + 4.0 * r * r / (tolerance * tolerance));
      H.noalias() += w * J * J.transpose();
      g.noalias() += w * r * J;
    }
    if (pull > 0.0) {
      H.diagonal().tail<3>().array() += pull;
      g.tail<3>() += pull * (X.R.transpose() * X.t);
    }
    H.diagonal().array() += 1e-6 * (1.0 + H.trace());
    const Vector6d dx = -solve_symmetric6(H, g);
    X = X * SE3::exp(dx);
    X.R = nearest_rotation(X.R);
    if (tolerance <= to_m && dx.norm() < settled_share * to_m) break;
    tolerance = std::max(to_m, 0.8 * tolerance);
  }
  return X;
}

std::vector<ScoredPose> refined_poses(const SurfelIndex& coarse, const SurfelIndex& fine, const MovingSurfels& moving,
                                      const std::vector<SE3>& starts) {
  const MovingSurfels few = thinned(moving, 300);
  const MovingSurfels some = thinned(moving, 1000);
  const MovingSurfels many = thinned(moving, 3000);
  std::vector<Candidate> all;
  for (const SE3& X : starts) all.push_back({X, 0.0});
  parallel_for(all.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      all[i].X = refine_registration(coarse, few, all[i].X, 0.4, 0.2);
      all[i].score = balanced_score(fine, few, all[i].X, same_surface_cosine, 0.15);
    }
  });
  std::vector<Candidate> best = best_apart(std::move(all), contenders, is_same);
  parallel_for(best.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      best[i].X = refine_registration(fine, some, best[i].X, 0.3, 0.08);
      best[i].score = balanced_score(fine, some, best[i].X, same_surface_cosine, same_surface_m);
    }
  });
  std::vector<Candidate> last = best_apart(std::move(best), finalists, is_same);
  parallel_for(last.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      last[i].X = refine_registration(fine, many, last[i].X, 0.12, 0.08);
      last[i].score = balanced_score(fine, many, last[i].X, same_surface_cosine, same_surface_m);
    }
  });
  sort_by_score(last);
  return last;
}

RegistrationResult refine_candidates(const SurfelIndex& coarse, const SurfelIndex& fine, const MovingSurfels& moving,
                                     const std::vector<SE3>& starts) {
  return result_of(refined_poses(coarse, fine, moving, starts));
}

RegistrationResult nearer_to_guess(const RegistrationResult& near, const RegistrationResult& far) {
  if (far.score >= clearly_better * near.score) return far;
  RegistrationResult out = near;
  const auto consider = [&](const SE3& X, double score) {
    if (!distinct(X, near.X) || score <= out.runner_up_score) return;
    out.runner_up = X;
    out.runner_up_score = score;
  };
  consider(far.X, far.score);
  consider(far.runner_up, far.runner_up_score);
  return out;
}

RegistrationResult register_surfels(const SurfelIndex& coarse, const SurfelIndex& fine, const MovingSurfels& moving,
                                    const SE3& guess) {
  const MovingSurfels few = thinned(moving, 400);
  const MovingSurfels many = thinned(moving, 3000);
  std::vector<Candidate> best =
      best_matches(coarse, few, search_grid(guess), {std::cos(to_rad(20.0)), 0.3}, refined, is_near);
  parallel_for(best.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      best[i].X = refine_registration(coarse, many, best[i].X, 0.8, 0.3);
      best[i].X = refine_registration(fine, many, best[i].X, 0.3, 0.08);
      best[i].score = balanced_score(fine, many, best[i].X, same_surface_cosine, same_surface_m);
    }
  });
  sort_by_score(best);
  return result_of(best);
}

}  // namespace rigcal
