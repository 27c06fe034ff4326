#include "core/camera/smooth_image.h"

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

GreyImage ramp() {
  GreyImage image{64, 48, {}};
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x)
      image.values.push_back(10.0F + 2.0F * static_cast<float>(x) + static_cast<float>(y));
  }
  return image;
}

TEST(SmoothImage, KeepsARampWhateverItsSize) {
  for (const int halvings : {0, 1, 2}) {
    const SmoothImage image(ramp(), halvings);
    for (const Vector2d& p : {Vector2d(20.0, 20.0), Vector2d(31.3, 17.8), Vector2d(40.5, 25.5)}) {
      const GreySample g = image.at(p);
      EXPECT_NEAR(g.value, 10.0 + 2.0 * p.x() + p.y(), 1e-3) << halvings;
      EXPECT_NEAR(g.slope.x(), 2.0, 1e-4);
      EXPECT_NEAR(g.slope.y(), 1.0, 1e-4);
      EXPECT_EQ(image.value(p), g.value);
    }
  }
}

TEST(SmoothImage, SlopesAgreeWithDifferences) {
  Random random(2);
  GreyImage noise{40, 30, {}};
  for (int k = 0; k < 40 * 30; ++k) noise.values.push_back(static_cast<float>(random.uniform(0.0, 255.0)));
  for (const int halvings : {0, 1}) {
    const SmoothImage image(noise, halvings);
    for (int k = 0; k < 100; ++k) {
      const Vector2d p(random.uniform(1.0, 38.0), random.uniform(1.0, 28.0));
      const GreySample g = image.at(p);
      for (int axis = 0; axis < 2; ++axis) {
        const Vector2d step = 0.01 * Vector2d::Unit(axis);
        EXPECT_NEAR(g.slope[axis], (image.value(p + step) - image.value(p - step)) / 0.02, 0.05);
      }
    }
  }
}

TEST(SmoothImage, SpreadsGreyValuesBetweenDarkAndBright) {
  const GreyScale scale{100.0F, 150.0F, 15.0F};
  const std::pair<float, float> expected[] = {
      {99.0F, 0.0F}, {100.0F, 0.0F}, {130.0F, 9.0F}, {150.0F, 15.0F}, {255.0F, 15.0F}};
  for (const auto& [grey, spread] : expected) {
    const GreyImage flat{8, 8, std::vector<float>(64, grey)};
    EXPECT_NEAR(SmoothImage(flat, 0, scale).value({4.0, 4.0}), spread, 1e-5F) << grey;
  }
}

TEST(SmoothImage, HalvesImagesOfOddSizeAndOfOnePixel) {
  const GreyImage odd = halved({5, 3, {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15}}, 1);
  EXPECT_EQ(odd.width, 2);
  EXPECT_EQ(odd.height, 1);
  EXPECT_EQ(odd.values, (std::vector<float>{4.0F, 6.0F}));
  EXPECT_EQ(halved({1, 4, {2, 4, 6, 8}}, 1).values, (std::vector<float>{3.0F, 7.0F}));
  EXPECT_EQ(halved({4, 1, {2, 4, 6, 8}}, 2).values, (std::vector<float>{5.0F}));
  EXPECT_EQ(halved({1, 1, {7}}, 3).values, (std::vector<float>{7.0F}));
}

TEST(SmoothImage, GoesOnBeyondItsBorders) {
  const SmoothImage image(ramp(), 0);
  EXPECT_EQ(image.value({-20.0, 20.0}), image.value({0.0, 20.0}));
  EXPECT_EQ(image.value({63.0, 100.0}), image.value({63.0, 47.0}));
  const SmoothImage dot({1, 1, {7.0F}}, 3);
  EXPECT_NEAR(dot.value({0.0, 0.0}), 7.0F, 1e-5F);
}

}  // namespace
}  // namespace rigcal
