#include "core/corner/plane_alignment.h"

#include <gtest/gtest.h>

#include "core/geometry/numeric_derivative.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

struct Clouds {
  std::vector<std::vector<Vector3d>> a;
  std::vector<std::vector<Vector3d>> b;
  std::vector<PlanePair> pairs;
};

FittedPlane fitted(const std::vector<Vector3d>& points) {
  PointCluster cluster;
  for (const Vector3d& p : points) cluster.add(p);
  return *fit_plane(cluster);
}

// Planes seen by both, each from its own points; b's frame is off by T_a_b.
Clouds make_clouds(int planes, const SE3& T_a_b, double sigma_m, Random& random) {
  Clouds out;
  for (int l = 0; l < planes; ++l) {
    const SE3 T_a_plane = random_pose(random, 1.5, 4.0);
    const auto draw = [&](const SE3& T_sensor_a) {
      std::vector<Vector3d> points;
      for (int k = 0; k < 400; ++k) {
        points.push_back(T_sensor_a *
                         (T_a_plane * Vector3d(random.normal(), random.normal(), sigma_m * random.normal())));
      }
      return points;
    };
    out.a.push_back(draw(SE3{}));
    out.b.push_back(draw(T_a_b.inverse()));
    PlanePair pair{fitted(out.a.back()), fitted(out.b.back()), 1.0, 1.0};
    if (pair.a.normal.dot(T_a_b.R * pair.b.normal) < 0.0) pair.b = pair.b.flipped();
    out.pairs.push_back(pair);
  }
  return out;
}

double cost_of_points(const Clouds& clouds, const SE3& T) {
  double cost = 0.0;
  for (std::size_t l = 0; l < clouds.pairs.size(); ++l) {
    for (const Vector3d& p : clouds.b[l]) cost += std::pow(clouds.pairs[l].a.distance(T * p), 2);
    for (const Vector3d& p : clouds.a[l]) cost += std::pow(clouds.pairs[l].b.distance(T.inverse() * p), 2);
  }
  return cost;
}

TEST(PlaneAlignment, HasTheJacobianThatDifferencesGive) {
  Random random(5);
  const SE3 T_a_b = random_pose(random, 1.0, 0.5);
  Clouds clouds = make_clouds(4, T_a_b, 0.05, random);
  clouds.pairs[1].weight_a = 3.0;
  clouds.pairs[1].weight_b = 0.2;
  for (const double disturbance : {0.0, 0.3, 2.0}) {
    const SE3 T = T_a_b * random_pose(random, disturbance, disturbance);
    for (const PlanePair& pair : clouds.pairs) {
      Eigen::Matrix<double, 8, 1> residuals;
      Eigen::Matrix<double, 8, 6> analytic;
      pair_residuals(pair, T, residuals, &analytic);
      const Eigen::MatrixXd numeric = numeric_jacobian(
          [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
            const SE3 moved{T.R * exp_so3(x.head<3>()), T.t + x.tail<3>()};
            Eigen::Matrix<double, 8, 1> values;
            pair_residuals(pair, moved, values, nullptr);
            return values;
          },
          6);
      EXPECT_LT((numeric - analytic).norm(), 1e-8 * (1.0 + analytic.norm()));
    }
  }
}

TEST(PlaneAlignment, HasTheCostOfThePointsUpToAConstant) {
  Random random(6);
  const SE3 T_a_b = random_pose(random, 1.0, 0.5);
  const Clouds clouds = make_clouds(3, T_a_b, 0.05, random);
  const auto cost_at = [&](const SE3& T) {
    double cost = 0.0;
    for (const PlanePair& pair : clouds.pairs) {
      Eigen::Matrix<double, 8, 1> residuals;
      pair_residuals(pair, T, residuals, nullptr);
      cost += residuals.squaredNorm();
    }
    return cost;
  };
  const SE3 T1 = T_a_b * random_pose(random, 0.2, 0.2);
  const SE3 T2 = T_a_b * random_pose(random, 0.5, 0.5);
  const double expected = cost_of_points(clouds, T1) - cost_of_points(clouds, T2);
  EXPECT_NEAR(cost_at(T1) - cost_at(T2), expected, 1e-9 * std::abs(expected));
}

TEST(PlaneAlignment, ComesBackFromADisturbedStart) {
  Random random(7);
  for (int k = 0; k < 20; ++k) {
    const SE3 T_a_b = random_pose(random, 1.0, 0.5);
    const Clouds clouds = make_clouds(5, T_a_b, 0.0, random);
    const auto found = align_planes(clouds.pairs, T_a_b * random_pose(random, 0.2, 0.3));
    EXPECT_TRUE(found.converged);
    EXPECT_THAT(found.T_a_b, SE3Near(T_a_b, 1e-5, 1e-3));
    EXPECT_LT(found.cost_after, 1e-9 * found.cost_before);
  }
}

TEST(PlaneAlignment, IsNotPulledByAPairThatIsNoneWhereTheKernelIsRobust) {
  Random random(8);
  const SE3 T_a_b = random_pose(random, 1.0, 0.5);
  Clouds clouds = make_clouds(6, T_a_b, 0.01, random);
  for (PlanePair& pair : clouds.pairs) pair.weight_a = pair.weight_b = 1e4;
  clouds.pairs[2].b.points = clouds.pairs[2].b.points.transformed(random_pose(random, 0.1, 0.3));
  clouds.pairs[2].b = *fit_plane(clouds.pairs[2].b.points);
  const auto plain = align_planes(clouds.pairs, T_a_b);
  const auto robust = align_planes(clouds.pairs, T_a_b, 3.0);
  EXPECT_GT((plain.T_a_b.t - T_a_b.t).norm(), 0.01);
  EXPECT_THAT(robust.T_a_b, SE3Near(T_a_b, 0.1, 3.0));
}

TEST(PlaneAlignment, OfNothingStaysWhereItStarts) {
  const SE3 start{exp_so3({0.1, 0.2, 0.3}), {1.0, 2.0, 3.0}};
  const auto found = align_planes({}, start);
  EXPECT_EQ(found.T_a_b.t, start.t);
  EXPECT_FALSE(found.converged);
}

}  // namespace
}  // namespace rigcal
