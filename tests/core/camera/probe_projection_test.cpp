#include "core/camera/probe_projection.h"

#include <gtest/gtest.h>

#include <array>

#include "core/base/random.h"

namespace rigcal {
namespace {

CameraIntrinsics bent(DistortionModel model) {
  CameraIntrinsics in;
  in.model = model;
  in.width = 1280;
  in.height = 1024;
  in.fx = 860.0;
  in.fy = 855.0;
  in.cx = 640.0;
  in.cy = 500.0;
  in.distortion = {-0.2, 0.06, 0.001, -0.002};
  if (model == DistortionModel::radtan) in.distortion.push_back(0.01);
  return in;
}

class Projection : public testing::TestWithParam<DistortionModel> {};

TEST_P(Projection, IsThatOfTheCameraModel) {
  const CameraModel model(bent(GetParam()));
  Random random(5);
  const auto off = [&] { return Vector3d(random.normal(), random.normal(), random.normal()); };
  ProbePoints points;
  std::vector<std::array<Vector3d, 2>> made;
  for (int k = 0; k < 500; ++k) {
    // Behind the camera, too.
    const Vector3d p = 3.0 * off() + Vector3d(0.0, 0.0, 4.0);
    const Vector3d beside = p + 0.02 * off();
    points.add(p, beside);
    made.push_back({p, beside});
  }
  const SE3 T = SE3{exp_so3({0.1, -0.05, 0.2}), {0.3, -0.1, 0.2}};
  constexpr std::size_t first = 30;
  ProbePoints::Pixels pixels;
  points.project(model, T, first, points.size(), pixels);
  int seen = 0;
  for (std::size_t k = 0; k < made.size() - first; ++k) {
    const auto pixel = model.project(T.inverse() * made[first + k][0]);
    const auto beside = model.project(T.inverse() * made[first + k][1]);
    if (!pixel || !beside) {
      EXPECT_LT(pixels.x[k], -1e6F);
      continue;
    }
    if (!model.contains(*pixel)) continue;
    ++seen;
    EXPECT_NEAR(pixels.x[k], pixel->x(), 2e-3);
    EXPECT_NEAR(pixels.y[k], pixel->y(), 2e-3);
    EXPECT_NEAR(pixels.along_x[k], beside->x() - pixel->x(), 2e-3);
    EXPECT_NEAR(pixels.along_y[k], beside->y() - pixel->y(), 2e-3);
  }
  EXPECT_GT(seen, 80);
}

INSTANTIATE_TEST_SUITE_P(Models, Projection, testing::Values(DistortionModel::radtan, DistortionModel::equidistant));

}  // namespace
}  // namespace rigcal
