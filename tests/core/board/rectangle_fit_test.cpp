#include "core/board/rectangle_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/base/random.h"
#include "core/geometry/numeric_derivative.h"
#include "core/geometry/se3.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

// Where horizontal lines `spacing` apart enter and leave a rectangle.
std::vector<OutlinePoint> ring_ends(const Vector2d& size, double angle, const Vector2d& center, double spacing,
                                    double growth, double sigma, Random& random) {
  std::vector<OutlinePoint> out;
  const Eigen::Rotation2Dd to_board(-angle);
  const Vector2d direction = to_board * Vector2d::UnitX();
  for (double y = -1.0 + spacing * random.uniform(); y < 1.0; y += spacing) {
    const Vector2d origin = to_board * (Vector2d(-2.0, y) - center);
    double enter = 0.0;
    double leave = 4.0;
    for (int axis = 0; axis < 2; ++axis) {
      const double half = 0.5 * size[axis] + growth;
      double a = (-half - origin[axis]) / direction[axis];
      double b = (half - origin[axis]) / direction[axis];
      if (a > b) std::swap(a, b);
      enter = std::max(enter, a);
      leave = std::min(leave, b);
    }
    if (leave - enter < 0.08) continue;
    out.push_back({{-2.0 + enter + sigma * random.normal(), y}, {-1.0, 0.0}});
    out.push_back({{-2.0 + leave + sigma * random.normal(), y}, {1.0, 0.0}});
  }
  return out;
}

TEST(RectangleFit, HasTheDerivativesThatDifferencesGive) {
  const Vector2d size(0.85, 0.61);
  RectangleFit fit;
  fit.angle_rad = 0.4;
  fit.center = {0.1, -0.2};
  fit.growth = {0.003, -0.002};
  const OutlinePoint point{{0.5, 0.1}, {1.0, 0.0}};
  for (int edge = 0; edge < 4; ++edge) {
    const auto f = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      RectangleFit moved = fit;
      moved.angle_rad += x[0];
      moved.center += x.segment<2>(1);
      moved.growth += x.tail<2>();
      return Eigen::VectorXd::Constant(1, edge_residual(point, size, moved, edge).value);
    };
    EXPECT_LT((numeric_jacobian(f, 5) - edge_residual(point, size, fit, edge).by_parameters).norm(), 1e-9) << edge;
  }
}

TEST(RectangleFit, FindsAPlateAtAnyTurnByTheEndsOfRings) {
  Random random(3);
  const Vector2d size(0.85, 0.61);
  for (int trial = 0; trial < 60; ++trial) {
    const double angle = pi * random.uniform();
    const Vector2d center(0.1 * random.normal(), 0.1 * random.normal());
    const auto outline = ring_ends(size, angle, center, 0.08, 0.004, 0.003, random);
    const auto fit = fit_rectangle(outline, size, 0.04, 0.01);
    ASSERT_TRUE(fit);
    // Edges along the rings are not seen: then the plate may shift across them by half a ring's distance.
    const double slope = std::abs(std::remainder(angle, 0.5 * pi));
    if (slope < to_rad(12.0)) continue;
    EXPECT_LT(std::abs(std::remainder(fit->angle_rad - angle, pi)), to_rad(2.0)) << to_deg(angle);
    EXPECT_LT((fit->center - center).norm(), 0.012) << to_deg(angle);
    EXPECT_GT(fit->used_share, 0.85) << to_deg(angle);
    EXPECT_LT(fit->rms_m, 0.006) << to_deg(angle);
  }
}

TEST(RectangleFit, WantsSixPoints) {
  const std::vector<OutlinePoint> outline(5, OutlinePoint{{0.0, 0.0}, {1.0, 0.0}});
  EXPECT_FALSE(fit_rectangle(outline, {1.0, 1.0}, 0.04, 0.01));
}

TEST(RectangleFit, KnowsHullsAndTheRectangleRoundThem) {
  std::vector<Vector2d> points;
  const Eigen::Rotation2Dd R(0.3);
  for (const auto& [x, y] : {std::pair{-1.0, -0.5}, {1.0, -0.5}, {1.0, 0.5}, {-1.0, 0.5}, {0.0, 0.0}, {0.2, 0.1}}) {
    points.push_back(R * Vector2d(x, y));
  }
  const auto hull = convex_hull(points);
  EXPECT_EQ(hull.size(), 4u);
  EXPECT_NEAR(area_of(hull), 2.0, 1e-12);
  EXPECT_LT((smallest_rectangle(hull) - Vector2d(2.0, 1.0)).norm(), 1e-12);
}

}  // namespace
}  // namespace rigcal
