#include "core/planes/point_to_plane.h"

#include <gtest/gtest.h>

#include "core/geometry/numeric_derivative.h"

namespace rigcal {
namespace {

// Two stops and two LiDARs anywhere; all free but the first stop.
struct Case {
  RigState state;
  ParameterLayout layout{2, 2};
  Vector3d normal = Vector3d(0.3, -0.5, 0.8).normalized();

  Case() {
    state.T_G_base = {SE3{exp_so3({0.1, 0.2, -0.3}), {1.0, 2.0, -0.5}},
                      SE3{exp_so3({-0.4, 0.1, 0.9}), {0.2, -1.0, 0.3}}};
    state.T_base_sensor = {SE3{}, SE3{exp_so3({0.7, -0.2, 2.0}), {-0.1, 0.4, 0.2}}};
    layout.free_stop(1);
    layout.free_lidar(0);
    layout.free_lidar(1);
  }

  void compare(const SensorPoint& a, const SensorPoint& b) const {
    const double distance = plane_distance(a, b, normal, state);
    const Eigen::MatrixXd J = numeric_jacobian(
        [&](const Eigen::VectorXd& dx) {
          return Eigen::VectorXd::Constant(1, plane_distance(a, b, normal, layout.moved(state, dx)));
        },
        layout.size());
    NormalEquations sum{0.0, Eigen::VectorXd::Zero(layout.size()), Eigen::MatrixXd::Zero(layout.size(), layout.size())};
    add_point_to_plane(a, b, normal, distance, 3.0, layout, state, sum);
    EXPECT_DOUBLE_EQ(sum.cost, 3.0 * distance * distance);
    EXPECT_LT((sum.g - 6.0 * distance * J.transpose()).norm(), 1e-8);
    const Eigen::MatrixXd H = 6.0 * J.transpose() * J;
    EXPECT_LT(
        (Eigen::MatrixXd(sum.H.triangularView<Eigen::Lower>()) - Eigen::MatrixXd(H.triangularView<Eigen::Lower>()))
            .norm(),
        1e-8);
  }
};

TEST(AddPointToPlane, AgreesWithDifferences) { Case().compare({0, 0, {4.0, 1.0, 0.3}}, {1, 1, {-2.0, 0.5, 1.0}}); }

TEST(AddPointToPlane, MovesBothEndsWhereTheyShareAStopOrALidar) {
  Case().compare({1, 0, {4.0, 1.0, 0.3}}, {1, 1, {-2.0, 0.5, 1.0}});
  Case().compare({0, 1, {4.0, 1.0, 0.3}}, {1, 1, {-2.0, 0.5, 1.0}});
}

}  // namespace
}  // namespace rigcal
