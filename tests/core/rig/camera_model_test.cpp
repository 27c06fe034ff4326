#include "core/rig/camera_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/geometry/numeric_derivative.h"
#include "tests/support/pinhole.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

CameraIntrinsics radtan() {
  // A lens of 6 mm on a sensor of 1280 x 1024, distorted as such lenses are.
  return {DistortionModel::radtan, 1280, 1024, 863.4, 861.2, 640.1, 518.3, {-0.0978, 0.0912, 4e-4, -7e-4, -0.014}};
}

CameraIntrinsics equidistant() {
  return {DistortionModel::equidistant, 1920, 1208, 1176.9, 1176.1, 962.1, 612.8, {-0.057, 0.017, -0.013, 0.0035}};
}

// A fisheye that sees 200 degrees.
CameraIntrinsics wide() {
  return {DistortionModel::equidistant, 1000, 1000, 285.0, 285.0, 499.5, 499.5, {-0.01, 0.002, -0.0006, 0.0001}};
}

class EveryCamera : public testing::TestWithParam<CameraIntrinsics> {
 protected:
  const CameraModel camera_{GetParam()};

  // Pixels over the whole image, the corners and the axis among them, where a ray exists.
  std::vector<Vector2d> pixels() const {
    const CameraIntrinsics& i = GetParam();
    std::vector<Vector2d> out{{i.cx, i.cy}, {i.cx + 1e-5, i.cy}, {i.cx, i.cy - 1e-3}};
    for (int a = 0; a <= 16; ++a) {
      for (int b = 0; b <= 16; ++b) {
        const Vector2d pixel((i.width - 1) * a / 16.0, (i.height - 1) * b / 16.0);
        if (camera_.ray(pixel)) out.push_back(pixel);
      }
    }
    return out;
  }
};

TEST_P(EveryCamera, SeesItsWholeImageAndComesBackToEveryPixel) {
  const std::vector<Vector2d> all = pixels();
  EXPECT_GE(all.size(), GetParam().width == 1000 ? 200U : 290U);  // the wide one's corners are black
  for (const Vector2d& pixel : all) {
    const Vector3d ray = *camera_.ray(pixel);
    EXPECT_NEAR(ray.norm(), 1.0, 1e-12);
    const auto back = camera_.project(7.3 * ray);
    ASSERT_TRUE(back);
    EXPECT_LT((*back - pixel).norm(), 1e-8) << pixel.transpose();
  }
}

TEST_P(EveryCamera, ConeAroundTheImageLeavesOutNothingThatIsSeen) {
  for (const Vector2d& pixel : pixels()) EXPECT_GE(camera_.ray(pixel)->z(), camera_.widest_cos()) << pixel.transpose();
}

TEST(CameraModel, ConeAroundTheImageIsNotMuchWiderThanIt) {
  const CameraModel camera(pinhole(640, 480, 500.0));
  const double corner = camera.ray({0.0, 0.0})->z();
  EXPECT_LT(camera.widest_cos(), corner);
  EXPECT_GT(camera.widest_cos(), corner - 0.1);
}

TEST_P(EveryCamera, DerivativesByPointAndIntrinsicsAgreeWithDifferencesOverTheWholeImage) {
  for (const Vector2d& pixel : pixels()) {
    const Vector3d p = 3.0 * *camera_.ray(pixel);
    PixelDerivatives derivatives;
    ASSERT_TRUE(camera_.project(p, derivatives));
    const Eigen::MatrixXd by_point = numeric_jacobian(
        [&](const Eigen::VectorXd& x) -> Eigen::VectorXd { return *camera_.project(p + Vector3d(x)); }, 3);
    EXPECT_LT((derivatives.by_point - by_point).norm(), 1e-6 * by_point.norm()) << pixel.transpose();

    Eigen::Matrix<double, 2, 3> alone;
    EXPECT_EQ(*camera_.project(p, alone), *camera_.project(p));
    EXPECT_EQ(alone, derivatives.by_point);

    const auto changed = [&](const Eigen::VectorXd& x) -> Eigen::VectorXd {
      CameraIntrinsics i = GetParam();
      i.fx += x[0];
      i.fy += x[1];
      i.cx += x[2];
      i.cy += x[3];
      for (std::size_t k = 0; k < i.distortion.size(); ++k) i.distortion[k] += x[4 + static_cast<long>(k)];
      return *CameraModel(i).project(p);
    };
    const Eigen::MatrixXd by_intrinsics = numeric_jacobian(changed, intrinsics_count, 1e-5);
    EXPECT_LT((derivatives.by_intrinsics - by_intrinsics).norm(), 1e-6 * by_intrinsics.norm()) << pixel.transpose();
  }
}

TEST_P(EveryCamera, ProjectsNothingBeyondItsLargestAngleNorWhatIsNoNumber) {
  const double limit = camera_.max_angle_rad();
  for (const double azimuth : {0.0, 1.0, 2.5, 4.0}) {
    const auto at = [&](double angle) {
      return Vector3d(std::sin(angle) * std::cos(azimuth), std::sin(angle) * std::sin(azimuth), std::cos(angle));
    };
    EXPECT_TRUE(camera_.project(at(limit - 1e-6)));
    if (limit < pi) {
      EXPECT_FALSE(camera_.project(at(limit + 1e-6)));  // where not, all but what is straight behind is seen
    }
  }
  EXPECT_FALSE(camera_.project({0.0, 0.0, -2.0}));
  EXPECT_FALSE(camera_.project({0.0, 0.0, 0.0}));
  EXPECT_FALSE(camera_.project({std::nan(""), 0.0, 1.0}));
  EXPECT_FALSE(camera_.ray({std::nan(""), 3.0}));
  EXPECT_FALSE(camera_.ray({1e9, 1e9}));
}

INSTANTIATE_TEST_SUITE_P(Models, EveryCamera, testing::Values(radtan(), equidistant(), wide()));

TEST(CameraModel, ARadtanCameraSeesNothingBehindItself) {
  const CameraModel camera(radtan());
  EXPECT_FALSE(camera.project({0.1, 0.2, -1.0}));
  EXPECT_FALSE(camera.project({0.1, 0.2, 0.0}));
}

TEST(CameraModel, AFisheyeSeesBeyondNinetyDegrees) {
  const CameraModel camera(wide());
  const auto pixel = camera.project({1.0, 0.0, -0.1});
  ASSERT_TRUE(pixel);
  EXPECT_TRUE(camera.contains(*pixel));
}

TEST(CameraModel, EndsWhereAStrongDistortionFoldsBack) {
  // 1 - 3 * 0.3 r^2 = 0 at r = 1.054: farther points would land on pixels that nearer ones have.
  const CameraModel camera({DistortionModel::radtan, 640, 480, 400, 400, 320, 240, {-0.3, 0.0, 0.0, 0.0, 0.0}});
  EXPECT_NEAR(std::tan(camera.max_angle_rad()), std::sqrt(1.0 / 0.9), 1e-9);
  EXPECT_TRUE(camera.project({1.05, 0.0, 1.0}));
  EXPECT_FALSE(camera.project({1.06, 0.0, 1.0}));
  EXPECT_FALSE(camera.ray({320.0 + 400.0 * 0.71, 240.0}));  // the fold is at 1.054 * 2 / 3 = 0.703
}

TEST(CameraModel, KnowsThePixelsOfItsImage) {
  const CameraModel camera(radtan());
  EXPECT_TRUE(camera.contains({0.0, 0.0}));
  EXPECT_TRUE(camera.contains({1279.0, 1023.0}));
  EXPECT_FALSE(camera.contains({1279.5, 5.0}));
  EXPECT_FALSE(camera.contains({3.0, 100.0}, 4.0));
}

}  // namespace
}  // namespace rigcal
