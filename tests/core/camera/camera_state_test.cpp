#include "core/camera/camera_state.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/geometry/numeric_derivative.h"

namespace rigcal {
namespace {

CameraIntrinsics lens(DistortionModel model) {
  if (model == DistortionModel::radtan) {
    return {model, 1280, 1024, 863.0, 861.0, 639.5, 511.5, {-0.10, 0.09, 0.0003, -0.0002, 0.01}};
  }
  return {model, 1280, 1024, 420.0, 421.0, 639.5, 511.5, {0.02, -0.004, 0.001, -0.0005}};
}

class CameraStateTest : public testing::TestWithParam<DistortionModel> {};

TEST_P(CameraStateTest, DerivativesAgreeWithDifferencesOverTheWholeImage) {
  const CameraIntrinsics intrinsics = lens(GetParam());
  CameraState state;
  state.T_base_camera.R = exp_so3(Vector3d(0.3, -1.1, 0.7));
  state.T_base_camera.t = Vector3d(0.05, -0.06, 0.4);
  state.focal_scale = 0.01;
  state.k1_change = -0.02;
  SE3 T_G_base;
  T_G_base.R = exp_so3(Vector3d(0.1, 0.2, 1.5));
  T_G_base.t = Vector3d(2.0, -1.0, 0.3);
  const CameraModel model(changed(intrinsics, state));
  int checked = 0;
  for (double x = 5.0; x < intrinsics.width; x += 127.0) {
    for (double y = 5.0; y < intrinsics.height; y += 113.0) {
      const auto ray = model.ray({x, y});
      if (!ray) continue;
      LidarEdge edge;
      edge.p_G = T_G_base * (state.T_base_camera * (4.0 * *ray));
      edge.direction_G = Vector3d(0.3, 0.8, -0.5).normalized();
      edge.covariance_G = 1e-6 * Matrix3d::Identity();
      const auto projection = project_edge(camera_at(model, state, T_G_base), edge);
      ASSERT_TRUE(projection);
      EXPECT_NEAR(projection->pixel.x(), x, 1e-6);
      EXPECT_NEAR(projection->pixel.y(), y, 1e-6);
      EXPECT_NEAR(projection->range_m, 4.0, 1e-9);
      EXPECT_NEAR(projection->sigma_px, 1e-3 * projection->px_per_m, 1e-9);
      const auto pixel = [&](const Eigen::VectorXd& step) -> Eigen::VectorXd {
        const CameraState there = moved(state, CameraVector(step));
        const CameraModel changed_model(changed(intrinsics, there));
        return *changed_model.project((T_G_base * there.T_base_camera).inverse() * edge.p_G);
      };
      const Eigen::MatrixXd numeric = numeric_jacobian(pixel, camera_parameters);
      EXPECT_LT((numeric - projection->jacobian).cwiseAbs().maxCoeff(), 1e-4) << x << " " << y;
      // The normal stands across where the edge goes on.
      LidarEdge further = edge;
      further.p_G += 1e-4 * edge.direction_G;
      const auto along = project_edge(camera_at(model, state, T_G_base), further);
      ASSERT_TRUE(along);
      EXPECT_NEAR(projection->normal.dot(along->pixel - projection->pixel), 0.0, 1e-4);
      ++checked;
    }
  }
  EXPECT_GT(checked, 80);
}

TEST_P(CameraStateTest, NothingBehindTheCameraOrAlongTheView) {
  const CameraModel model(lens(GetParam()));
  const CameraAtStop camera = camera_at(model, {}, {});
  LidarEdge edge;
  edge.p_G = Vector3d(0.0, 0.0, -3.0);
  EXPECT_FALSE(project_edge(camera, edge));
  edge.p_G = Vector3d(0.0, 0.0, 3.0);
  EXPECT_TRUE(project_edge(camera, edge));
  edge.direction_G = Vector3d::UnitZ();
  EXPECT_FALSE(project_edge(camera, edge));
}

INSTANTIATE_TEST_SUITE_P(Models, CameraStateTest,
                         testing::Values(DistortionModel::radtan, DistortionModel::equidistant));

}  // namespace
}  // namespace rigcal
