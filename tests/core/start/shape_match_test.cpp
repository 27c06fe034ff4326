#include "core/start/shape_match.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/numeric_derivative.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/start/registration.h"
#include "core/start/shape_start.h"
#include "tests/support/make_cells.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

// A road between poles: its one plane holds height, roll and pitch only.
std::vector<Wall> make_road() {
  std::vector<Wall> walls{{Vector3d(0, 0, -2), 20 * Vector3d::UnitX(), 8 * Vector3d::UnitY()}};
  const double places[][2] = {{3, 5}, {7, -5.5}, {-5, 5.2}, {-8, -5}, {13, 4.6}, {1, -6}, {-14, 5.8}, {16, -4.4}};
  for (const auto& at : places) {
    // A square post of 16 cm: two crossed strips.
    const Vector3d foot(at[0], at[1], -0.2);
    walls.push_back({foot, 0.08 * Vector3d::UnitX(), 1.8 * Vector3d::UnitZ()});
    walls.push_back({foot, 0.08 * Vector3d::UnitY(), 1.8 * Vector3d::UnitZ()});
  }
  return walls;
}

class ShapeMatching : public ::testing::Test {
 protected:
  void SetUp() override {
    Random random(11);
    View view;
    view.points_per_m2 = 40.0;
    view.noise.range_m = 0.01;
    patches_.push_back(cells_of(see(make_road(), SE3{}, view, random), 0, 0));
    patches_.push_back(cells_of(see(make_road(), truth_, view, random), 1, 0));
  }

  const SE3 truth_{exp_so3(Vector3d(0.3, 0.2, 1.5)), Vector3d(0.1, 0.5, -0.3)};
  std::vector<PatchCells> patches_;
};

TEST_F(ShapeMatching, FindsThePlaceAlongARoadByItsPolesAlone) {
  const ShapeMap map(patches_, 0, {SE3{}}, {1});
  Random random(5);
  for (int k = 0; k < 3; ++k) {
    const Vector3d axis = Vector3d(random.normal(), random.normal(), random.normal()).normalized();
    const SE3 guess{truth_.R * exp_so3(to_rad(10.0) * axis), truth_.t - 0.2 * axis};
    const ShapeMatch match = map.place(patches_, 1, search_grid(guess));
    // A fifth of a cell is 4 cm: what eight poles of half a cell's width can be placed to.
    EXPECT_THAT(match.X, SE3Near(truth_, 0.4, 40.0)) << "guess " << k;
    EXPECT_LT(match.runner_up_score, 0.95 * match.score);
  }
}

TEST_F(ShapeMatching, HasTheGradientOfItsCost) {
  const ShapeLevel level = shape_levels()[1];
  const auto sharp = [&](const PatchCells& patch) {
    std::vector<LocalShape> out = extract_shapes(patch, level.size_m);
    for (LocalShape& s : out) s.covariance = sharpened(s.covariance, level.sigma_m);
    return out;
  };
  const ShapeIndex index(sharp(patches_[0]), level.reach_m);
  MovingShapes moving{{SE3{}}, {}};
  for (const LocalShape& s : sharp(patches_[1])) {
    // Round shapes only turn into themselves: then the weights are constant, as the derivative takes them to be.
    moving.items.push_back({0, {s.mean, 0.01 * Matrix3d::Identity()}});
  }
  Vector6d off;
  off << 0.01, -0.008, 0.006, 0.03, 0.02, -0.03;
  const SE3 X = truth_ * SE3::exp(off);
  const ShapeScene scene{index, moving};
  const auto cost = [&](const Eigen::VectorXd& xi) -> Eigen::VectorXd {
    return Eigen::VectorXd::Constant(1, shape_equations(scene, X * SE3::exp(xi)).cost);
  };
  const Eigen::VectorXd numeric = numeric_jacobian(cost, 6, 1e-7).transpose();
  const Vector6d g = shape_equations(scene, X).g;
  // Rounding of a sum of some 1e3 over steps of 1e-7; a partner that changes within the step would show far above.
  EXPECT_LT((numeric - g).norm(), 1e-3 * g.norm());
}

TEST(Shapes, GrowPastASingleRingButLeaveAPoleALine) {
  Random random(3);
  // Rings on the ground, 0.5 m apart, and a pole.
  std::vector<Point> points;
  const auto add = [&](double x, double y, double z) {
    Point p;
    p.x = static_cast<float>(x);
    p.y = static_cast<float>(y);
    p.z = static_cast<float>(z);
    points.push_back(p);
  };
  for (int ring = 0; ring < 12; ++ring) {
    for (int k = 0; k < 4000; ++k) {
      const double a = 2.0 * pi * k / 4000;
      add((5.0 + 0.5 * ring) * std::cos(a), (5.0 + 0.5 * ring) * std::sin(a), -2.0);
    }
  }
  const PatchCells ground = cells_of(points, 0, 0);
  for (const LocalShape& s : extract_shapes(ground, 0.2)) {
    const SymmetricEigen eigen = symmetric_eigen(s.covariance);
    EXPECT_GT(std::abs(eigen.vectors.col(0).z()), 0.99);
    EXPECT_GT(eigen.values[1], 0.01 * eigen.values[2]);
  }
  points.clear();
  for (int k = 0; k < 400; ++k) add(8.0 + 0.02 * random.normal(), 0.02 * random.normal(), 0.01 * k);
  const std::vector<LocalShape> pole = extract_shapes(cells_of(points, 0, 0), 0.2);
  ASSERT_FALSE(pole.empty());
  for (const LocalShape& s : pole) {
    const SymmetricEigen eigen = symmetric_eigen(s.covariance);
    EXPECT_GT(std::abs(eigen.vectors.col(2).z()), 0.99);
    // No wider than its noise of 2 cm and the two cells that it may stand between.
    EXPECT_LT(std::sqrt(eigen.values[1]), 0.04);
  }
}

}  // namespace
}  // namespace rigcal
