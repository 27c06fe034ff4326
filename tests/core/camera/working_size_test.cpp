#include "core/camera/working_size.h"

#include <gtest/gtest.h>

#include "core/edges/grey_image.h"
#include "core/rig/camera_model.h"

namespace rigcal {
namespace {

CameraIntrinsics lens(int width, int height, double focal_length) {
  return {DistortionModel::radtan, width,        height,        focal_length,
          1.01 * focal_length,     0.49 * width, 0.52 * height, {-0.1, 0.02, 0.001, -0.0005, 0.0}};
}

TEST(WorkingSize, IsThatOfSmallImagesUnlessAPixelWouldSeeTooMuch) {
  EXPECT_EQ(halvings_of(lens(1280, 1024, 863.0)), 0);
  EXPECT_EQ(halvings_of(lens(1280, 1024, 3000.0)), 0);
  EXPECT_EQ(halvings_of(lens(1920, 1080, 1900.0)), 0);
  EXPECT_EQ(halvings_of(lens(2448, 2048, 2900.0)), 1);
  EXPECT_EQ(halvings_of(lens(4000, 3000, 1200.0)), 0);  // a fisheye lens
  EXPECT_EQ(halvings_of(lens(4000, 3000, 2400.0)), 1);
  EXPECT_EQ(halvings_of(lens(5120, 4096, 3452.0)), 2);
  EXPECT_EQ(halvings_of(lens(11648, 8736, 9000.0)), 3);
}

TEST(WorkingSize, SeesTheSamePlaceInTheSamePicture) {
  const CameraIntrinsics given = lens(101, 81, 90.0);
  GreyImage grey{101, 81, {}};
  for (int y = 0; y < grey.height; ++y) {
    for (int x = 0; x < grey.width; ++x) grey.values.push_back(static_cast<float>(2 * x + y));
  }
  const GreyImage small = halved(grey, 2);
  const CameraIntrinsics of_small = halved(given, 2);
  EXPECT_EQ(small.width, 25);
  EXPECT_EQ(small.height, 20);
  EXPECT_EQ(of_small.width, small.width);
  EXPECT_EQ(of_small.height, small.height);
  const CameraModel model(given);
  const CameraModel model_of_small(of_small);
  const auto large_at = model.project({0.1, -0.2, 1.5});
  const auto small_at = model_of_small.project({0.1, -0.2, 1.5});
  ASSERT_TRUE(large_at && small_at);
  // Grey values that are linear in the place are so in the mean of pixels, too: they tell where that is.
  const Eigen::Vector2d first(small.at(0, 0), small.at(1, 1) - small.at(0, 0));
  EXPECT_NEAR(first.x(), 2 * 1.5 + 1.5, 1e-4);
  EXPECT_NEAR(first.y(), 2 * 4 + 4, 1e-4);
  EXPECT_LT((*large_at - (4.0 * *small_at + Eigen::Vector2d::Constant(1.5))).norm(), 1e-9);
}

TEST(WorkingSize, IsUndoneInWhatWasFound) {
  const CameraIntrinsics given = lens(5121, 4097, 3452.0);
  CameraEstimate estimate;
  estimate.intrinsics = halved(given, 2);
  estimate.residual_px = 0.2;
  estimate.hold_out_px = 0.3;
  estimate.hold_out_start_px = 1.0;
  estimate.radial_trend = {0.1, 0.05};
  estimate.focal_scale = {0.001, 0.0005};
  const CameraEstimate full = at_full_size(estimate, given, 2);
  EXPECT_EQ(full.intrinsics.width, given.width);
  EXPECT_EQ(full.intrinsics.height, given.height);
  EXPECT_NEAR(full.intrinsics.fx, given.fx, 1e-9);
  EXPECT_NEAR(full.intrinsics.fy, given.fy, 1e-9);
  EXPECT_NEAR(full.intrinsics.cx, given.cx, 1e-9);
  EXPECT_NEAR(full.intrinsics.cy, given.cy, 1e-9);
  EXPECT_EQ(full.intrinsics.distortion, given.distortion);
  EXPECT_DOUBLE_EQ(full.residual_px, 0.8);
  EXPECT_DOUBLE_EQ(full.hold_out_px, 1.2);
  EXPECT_DOUBLE_EQ(full.hold_out_start_px, 4.0);
  EXPECT_DOUBLE_EQ(full.radial_trend.value, 0.4);
  EXPECT_DOUBLE_EQ(full.radial_trend.sigma, 0.2);
  EXPECT_EQ(full.focal_scale.value, 0.001);
  EXPECT_EQ(at_full_size(estimate, halved(given, 2), 0).residual_px, 0.2);
}

}  // namespace
}  // namespace rigcal
