#pragma once

#include <vector>

#include "core/planes/adjust.h"
#include "core/start/shapes.h"

namespace rigcal {

/// Shapes to be laid on an index by one unknown pose X: item k stands at places[place_k] * X * mean_k.
struct MovingShapes {
  std::vector<SE3> places;
  struct Item {
    int place = 0;
    LocalShape shape;
  };
  std::vector<Item> items;
};

/// About `count` of the items, evenly over the list.
[[nodiscard]] MovingShapes thinned(const MovingShapes& moving, std::size_t count);

/// How finely shapes are compared.
struct ShapeLevel {
  double size_m;   ///< One shape for each cube of this size.
  double reach_m;  ///< A partner is looked for this far.
  double sigma_m;  ///< Expected distance of two surfaces that are one: noise, and the error of the pose.
};

/// From a metre to the cells themselves.
[[nodiscard]] std::vector<ShapeLevel> shape_levels();

/// The covariance with its wide directions made wider still, by the square over the narrowest, sigma^2 added first: so
/// a plane holds along its normal only (two samplings of one wall do not hold each other along it), a pole across
/// itself.
[[nodiscard]] Matrix3d sharpened(const Matrix3d& covariance, double sigma_m);

/// One level of a match: `map` in the world, `moving` in the sensor's frame, all covariances sharpened.
struct ShapeScene {
  const ShapeIndex& map;
  MovingShapes moving;
};

/// Cost at X: sum over items of m / (1 + m / 4), with m = d^T (C_map + R C R^T)^-1 d to the nearest shape (an item
/// without one: the bound of 4), its gradient and Gauss-Newton Hessian for X exp(xi), partners and weights held.
struct ShapeEquations {
  double cost = 0.0;
  Vector6d g = Vector6d::Zero();
  Matrix6d H = Matrix6d::Zero();

  ShapeEquations& operator+=(const ShapeEquations& other);
};
[[nodiscard]] ShapeEquations shape_equations(const ShapeScene& scene, const SE3& X);

/// Share of what the cost could be that X saves: 1 all on the map, 0 nothing.
[[nodiscard]] double shape_score(const ShapeScene& scene, const SE3& X);

struct ShapeMatch {
  SE3 X;
  double score = 0.0;            ///< At the finest level.
  double runner_up_score = 0.0;  ///< Best score of a distinctly other pose; 0: none.
  SE3 runner_up;
  /// Of X exp(xi), from the scatter of the gradients of blocks of 4 m (sandwich), since neighbours share their errors,
  /// and a floor of a centimetre and a tenth of a degree: two samplings of a hedge differ by more than chance.
  Matrix6d covariance = Matrix6d::Zero();
};

/// The match as evidence for an adjustment.
[[nodiscard]] PosePrior prior_of(const ShapeMatch& match);

/// Tries all `candidates` at the coarsest scene, refines the best through all scenes and chooses by the finest score.
[[nodiscard]] ShapeMatch match_shapes(const std::vector<ShapeScene>& scenes, const std::vector<SE3>& candidates);

}  // namespace rigcal
