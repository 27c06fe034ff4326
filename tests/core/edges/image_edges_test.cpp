#include "core/edges/image_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/random.h"
#include "core/geometry/se3.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

// Dark below, bright above the line n.p = d, each pixel the mean over its area, with blur of the lens and noise.
GreyImage step(int width, int height, const Vector2d& n, double d, double low, double high, double noise,
               std::uint64_t seed) {
  GreyImage image{width, height, std::vector<float>(static_cast<std::size_t>(width * height))};
  Random random(seed);
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      double sum = 0.0;
      for (int a = 0; a < 4; ++a) {
        for (int b = 0; b < 4; ++b) {
          const double distance = n.dot(Vector2d(x + (a - 1.5) / 4.0, y + (b - 1.5) / 4.0)) - d;
          sum += 0.5 + 0.5 * std::erf(distance / (0.6 * std::sqrt(2.0)));
        }
      }
      image.values[static_cast<std::size_t>(y * width + x)] =
          static_cast<float>(low + (high - low) * sum / 16.0 + noise * random.normal());
    }
  }
  return image;
}

TEST(ImageEdges, AStepIsFoundToAFewHundredthsOfAPixelAtEveryAngle) {
  for (int k = 0; k < 12; ++k) {
    const double angle = to_rad(30.0 * k + 7.0);
    const Vector2d n(std::cos(angle), std::sin(angle));
    const double d = n.dot(Vector2d(63.3, 47.8));
    const GreyImage image = step(128, 96, n, d, 60, 140, 2.0, static_cast<std::uint64_t>(k));
    const std::vector<ImageEdge> edges = find_image_edges(image);
    ASSERT_GT(edges.size(), 60U);
    double squares = 0.0;
    for (const ImageEdge& edge : edges) {
      squares += std::pow(n.dot(edge.position.cast<double>()) - d, 2);
      EXPECT_GT(n.dot(edge.normal.cast<double>()), std::cos(to_rad(6.0)));
    }
    EXPECT_LT(std::sqrt(squares / static_cast<double>(edges.size())), 0.06) << 30 * k + 7;
  }
}

TEST(ImageEdges, OneStraightEdgeIsOneChain) {
  const std::vector<ImageEdge> edges = find_image_edges(step(200, 150, {0.8, 0.6}, 120.0, 50, 90, 1.0, 3));
  std::map<int, int> sizes;
  for (const ImageEdge& edge : edges) ++sizes[edge.chain];
  EXPECT_EQ(sizes.size(), 1U);
}

TEST(ImageEdges, NoiseAloneHasNone) {
  for (const double noise : {0.0, 1.0, 5.0, 20.0}) {
    const GreyImage image = step(320, 240, {1.0, 0.0}, 1000.0, 100, 100, noise, 4);
    EXPECT_TRUE(find_image_edges(image).empty()) << noise;
  }
}

TEST(ImageEdges, AFaintEdgeIsFoundWhereItStandsOutOfTheNoiseOnly) {
  EXPECT_FALSE(find_image_edges(step(128, 96, {1.0, 0.0}, 60.2, 100, 110, 0.5, 5)).empty());
  EXPECT_TRUE(find_image_edges(step(128, 96, {1.0, 0.0}, 60.2, 100, 110, 15.0, 5)).empty());
}

TEST(ImageEdges, SpecksAreClutter) {
  GreyImage image{200, 200, std::vector<float>(200 * 200, 80.0F)};
  Random random(6);
  for (int k = 0; k < 60; ++k) {
    const auto x = static_cast<int>(random.below(190));
    const auto y = static_cast<int>(random.below(190));
    for (int i = 0; i < 3; ++i) image.values[static_cast<std::size_t>((y + i) * 200 + x + i % 2)] = 200.0F;
  }
  EXPECT_TRUE(find_image_edges(image).empty());
}

TEST(ImageEdges, TinyAndEmptyImagesHaveNone) {
  EXPECT_TRUE(find_image_edges({}).empty());
  EXPECT_TRUE(find_image_edges({3, 2, std::vector<float>(6, 1.0F)}).empty());
}

TEST(Blurred, KeepsFlatImagesAndSpreadsAPointByItsSigma) {
  GreyImage image{41, 41, std::vector<float>(41 * 41, 10.0F)};
  for (const float v : blurred(image, 2.0).values) EXPECT_NEAR(v, 10.0F, 1e-4F);
  image.values.assign(41 * 41, 0.0F);
  image.values[20 * 41 + 20] = 1.0F;
  const GreyImage spread = blurred(image, 2.0);
  double sum = 0.0;
  double second = 0.0;
  for (int y = 0; y < 41; ++y) {
    for (int x = 0; x < 41; ++x) {
      sum += static_cast<double>(spread.at(x, y));
      second += static_cast<double>(spread.at(x, y)) * (x - 20) * (x - 20);
    }
  }
  EXPECT_NEAR(sum, 1.0, 1e-5);
  EXPECT_NEAR(second, 4.0, 0.02);
}

}  // namespace
}  // namespace rigcal
