#include "core/start/shape_match.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

#include "core/base/best_apart.h"
#include "core/base/parallel.h"
#include "core/geometry/matrix6.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/start/scored_pose.h"

namespace rigcal {
namespace {

constexpr double bound = 4.0;  // squared sigmas at which an item counts half
constexpr std::size_t refined = 12;
constexpr std::size_t scanned_items = 400;
constexpr double block_m = 4.0;
constexpr double floor_m = 0.01;
constexpr double floor_rad = to_rad(0.1);

// What one item adds at X. False: no partner.
struct ItemTerms {
  double m = 0.0;
  Vector6d g = Vector6d::Zero();
  Matrix6d H = Matrix6d::Zero();
};

template <bool with_derivatives>
bool item_terms(const ShapeScene& scene, const MovingShapes::Item& item, const SE3& X, ItemTerms& out) {
  const SE3 T = scene.moving.places[static_cast<std::size_t>(item.place)] * X;
  const Vector3d p = T * item.shape.mean;
  const int hit = scene.map.nearest(p);
  if (hit < 0) return false;
  const LocalShape& partner = scene.map[hit];
  const Vector3d d = p - partner.mean;
  const Matrix3d C = partner.covariance + T.R * item.shape.covariance * T.R.transpose();
  const Matrix3d W = C.inverse();
  const Vector3d Wd = W * d;
  out.m = d.dot(Wd);
  if constexpr (with_derivatives) {
    // d p / d xi = R [-[a]x, I]; the robust weight is the cost's derivative by m.
    Eigen::Matrix<double, 3, 6> J;
    J << -T.R * skew(item.shape.mean), T.R;
    const double w = 1.0 / std::pow(1.0 + out.m / bound, 2);
    out.g = 2.0 * w * J.transpose() * Wd;
    out.H = 2.0 * w * J.transpose() * W * J;
  }
  return true;
}

double saved(double m) { return 1.0 / (1.0 + m / bound); }

SE3 refine(const ShapeScene& scene, const SE3& start, int iterations) {
  SE3 X = start;
  for (int k = 0; k < iterations; ++k) {
    ShapeEquations sum = shape_equations(scene, X);
    sum.H.diagonal() += 1e-6 * sum.H.diagonal() + Vector6d::Constant(1e-9);
    const Vector6d dx = -solve_symmetric6(sum.H, sum.g);
    if (!dx.allFinite()) return start;
    X = X * SE3::exp(dx);
    X.R = nearest_rotation(X.R);
    if (dx.norm() < 1e-5) break;
  }
  return X;
}

Matrix6d sandwich(const ShapeScene& scene, const SE3& X) {
  std::map<std::tuple<int, int, int>, Vector6d> blocks;
  Matrix6d H = Matrix6d::Zero();
  for (const MovingShapes::Item& item : scene.moving.items) {
    ItemTerms terms;
    if (!item_terms<true>(scene, item, X, terms)) continue;
    const Vector3d p = scene.moving.places[static_cast<std::size_t>(item.place)] * (X * item.shape.mean) / block_m;
    const auto key = std::make_tuple(static_cast<int>(std::floor(p.x())), static_cast<int>(std::floor(p.y())),
                                     static_cast<int>(std::floor(p.z())));
    blocks.try_emplace(key, Vector6d::Zero()).first->second += terms.g;
    H += terms.H;
  }
  Matrix6d G = Matrix6d::Zero();
  for (const auto& [key, g] : blocks) G += g * g.transpose();
  H.diagonal() += 1e-9 * H.diagonal() + Vector6d::Constant(1e-9);
  const Matrix6d inverse = inverse_symmetric6(H);
  Matrix6d covariance = inverse * G * inverse.transpose();
  covariance.diagonal().head<3>().array() += floor_rad * floor_rad;
  covariance.diagonal().tail<3>().array() += floor_m * floor_m;
  return covariance;
}

}  // namespace

MovingShapes thinned(const MovingShapes& moving, std::size_t count) {
  const std::size_t size = moving.items.size();
  if (size <= count) return moving;
  MovingShapes out{moving.places, {}};
  for (std::size_t i = 0; i < count; ++i) out.items.push_back(moving.items[i * size / count]);
  return out;
}

std::vector<ShapeLevel> shape_levels() { return {{1.0, 2.0, 0.3}, {0.5, 1.0, 0.12}, {0.2, 0.5, 0.04}}; }

Matrix3d sharpened(const Matrix3d& covariance, double sigma_m) {
  const SymmetricEigen eigen = symmetric_eigen(covariance);
  const Vector3d l = eigen.values.cwiseMax(0.0).array() + sigma_m * sigma_m;
  return eigen.vectors * (l.array().square() / l[0]).matrix().asDiagonal() * eigen.vectors.transpose();
}

ShapeEquations& ShapeEquations::operator+=(const ShapeEquations& other) {
  cost += other.cost;
  g += other.g;
  H += other.H;
  return *this;
}

ShapeEquations shape_equations(const ShapeScene& scene, const SE3& X) {
  return parallel_sum(scene.moving.items.size(), 512, ShapeEquations{}, [&](std::size_t begin, std::size_t end) {
    ShapeEquations part;
    for (std::size_t i = begin; i < end; ++i) {
      ItemTerms terms;
      if (!item_terms<true>(scene, scene.moving.items[i], X, terms)) {
        part.cost += bound;
        continue;
      }
      part.cost += terms.m * saved(terms.m);
      part.g += terms.g;
      part.H += terms.H;
    }
    return part;
  });
}

double shape_score(const ShapeScene& scene, const SE3& X) {
  if (scene.moving.items.empty()) return 0.0;
  double sum = 0.0;
  for (const MovingShapes::Item& item : scene.moving.items) {
    ItemTerms terms;
    if (item_terms<false>(scene, item, X, terms)) sum += saved(terms.m);
  }
  return sum / static_cast<double>(scene.moving.items.size());
}

PosePrior prior_of(const ShapeMatch& match) { return {match.X, inverse6(match.covariance)}; }

ShapeMatch match_shapes(const std::vector<ShapeScene>& scenes, const std::vector<SE3>& candidates) {
  std::vector<ScoredPose> all;
  for (const SE3& X : candidates) all.push_back({X, 0.0});
  const ShapeScene few{scenes.front().map, thinned(scenes.front().moving, scanned_items)};
  parallel_for(all.size(), 16, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) all[i].score = shape_score(few, all[i].X);
  });
  std::vector<ScoredPose> best = best_apart(std::move(all), refined, [](const ScoredPose& a, const ScoredPose& b) {
    return rotation_distance(a.X.R, b.X.R) < to_rad(4.5) && (a.X.t - b.X.t).norm() < 0.3;
  });
  for (std::size_t level = 0; level < scenes.size(); ++level) {
    parallel_for(best.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        best[i].X = refine(scenes[level], best[i].X, 12);
        best[i].score = shape_score(scenes[level], best[i].X);
      }
    });
    // What has run into the same place needs no second look.
    best = best_apart(std::move(best), refined, is_same);
  }
  ShapeMatch match;
  if (best.empty() || scenes.back().moving.items.empty()) return match;
  match.X = refine(scenes.back(), best[0].X, 30);
  match.score = shape_score(scenes.back(), match.X);
  match.covariance = sandwich(scenes.back(), match.X);
  if (best.size() > 1) {
    match.runner_up = best[1].X;
    match.runner_up_score = best[1].score;
  }
  return match;
}

}  // namespace rigcal
