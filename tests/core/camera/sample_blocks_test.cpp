#include "core/camera/sample_blocks.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/random.h"

namespace rigcal {
namespace {

std::vector<MapSample> random_samples(std::size_t count, double half_m) {
  Random random(5);
  std::vector<MapSample> samples(count);
  for (MapSample& sample : samples) {
    for (int axis = 0; axis < 3; ++axis) sample.p_G[axis] = static_cast<float>(random.uniform(-half_m, half_m));
  }
  return samples;
}

// Those of each cube of 2 m together.
std::vector<MapSample> sorted_samples(std::size_t count, double half_m) {
  std::vector<MapSample> samples = random_samples(count, half_m);
  const auto cube = [](const MapSample& s) {
    const Eigen::Vector3f at = (0.5F * s.p_G).array().floor();
    return std::array<float, 3>{at.x(), at.y(), at.z()};
  };
  std::stable_sort(samples.begin(), samples.end(),
                   [&](const MapSample& a, const MapSample& b) { return cube(a) < cube(b); });
  return samples;
}

TEST(SampleBlocks, HoldAllSamplesEachInItsBall) {
  const std::vector<MapSample> samples = sorted_samples(2000, 4.0);
  const std::vector<SampleBlock> blocks = blocks_of(samples, 2.0);
  EXPECT_EQ(blocks.size(), 64U);
  std::uint32_t next = 0;
  for (const SampleBlock& block : blocks) {
    EXPECT_EQ(block.begin, next);
    next = block.end;
    EXPECT_LE(block.radius_m, std::sqrt(3.0F) + 1e-4F);
    for (std::uint32_t i = block.begin; i < block.end; ++i)
      EXPECT_LE((samples[i].p_G - block.middle).norm(), block.radius_m + 1e-5F);
  }
  EXPECT_EQ(next, samples.size());
  EXPECT_TRUE(blocks_of({}).empty());
}

TEST(SampleBlocks, AConeMeetsEveryBlockOfWhichItHoldsASample) {
  const std::vector<MapSample> samples = sorted_samples(4000, 6.0);
  const std::vector<SampleBlock> blocks = blocks_of(samples, 2.0);
  const SE3 T_C_G{exp_so3({0.4, -1.0, 0.2}), {0.3, -0.5, 0.8}};
  for (const double half_rad : {0.05, 0.7, 0.5 * pi, 2.5, pi}) {
    const ViewCone cone(T_C_G, half_rad);
    std::size_t met = 0;
    for (const SampleBlock& block : blocks) {
      std::size_t held = 0;
      for (std::uint32_t i = block.begin; i < block.end; ++i) {
        const Vector3d p_C = T_C_G * samples[i].p_G.cast<double>();
        const double off_axis = std::acos(p_C.z() / p_C.norm());
        if (std::abs(off_axis - half_rad) < 1e-3) continue;
        EXPECT_EQ(cone.holds(samples[i].p_G), off_axis < half_rad);
        if (off_axis < half_rad) ++held;
      }
      EXPECT_TRUE(cone.meets(block) || held == 0);
      if (cone.meets(block)) ++met;
    }
    // And passes over what lies beside it.
    EXPECT_LE(met, half_rad < 0.5 ? blocks.size() / 4 : blocks.size());
    EXPECT_GE(met, half_rad == pi ? blocks.size() : std::size_t{1});
  }
}

}  // namespace
}  // namespace rigcal
