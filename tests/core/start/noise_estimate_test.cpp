#include "core/start/noise_estimate.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"

namespace rigcal {
namespace {

const NoiseModel fallback{0.02, 0.0, 0.0005, 0.0};

// The law of the simulated LiDARs: 15 mm + 0.25 mm/m along the ray, 0.03 degrees across.
double range_sigma(double r) { return 0.015 + 0.25e-3 * r; }
constexpr double angle_sigma = 0.03 * pi / 180.0;

// Surfels of 100 points at 3 to 40 m, met at any angle; `rough` of them are up to six times as thick.
PatchSurfels seen_by(int lidar, int count, double rough, Random& random, double growth = 0.0) {
  PatchSurfels patch{lidar, 0, {}};
  for (int i = 0; i < count; ++i) {
    Surfel s;
    const double r = 3.0 * std::pow(40.0 / 3.0, random.uniform());
    s.mean = r * Vector3d::UnitX();
    const double cos_incidence = random.uniform(0.2, 1.0);
    s.normal = Vector3d(-cos_incidence, std::sqrt(1.0 - cos_incidence * cos_incidence), 0.0);
    s.N = 100.0;
    const double sin2 = 1.0 - cos_incidence * cos_incidence;
    const double slant = 1.0 + growth * (1.0 - cos_incidence);
    s.variance = std::pow(slant * range_sigma(r) * cos_incidence, 2) + r * r * angle_sigma * angle_sigma * sin2;
    // As the variance of a hundred points scatters.
    s.variance *= 1.0 + std::sqrt(2.0 / s.N) * random.normal();
    if (random.uniform() < rough) s.variance *= std::pow(36.0, random.uniform());
    patch.surfels.push_back(s);
  }
  return patch;
}

void expect_law(const NoiseModel& noise, double tolerance) {
  for (const double r : {5.0, 10.0, 20.0, 35.0}) {
    const double along = std::sqrt(noise.variance_along(r * Vector3d::UnitX(), Vector3d::UnitX()));
    EXPECT_NEAR(1.0, along / range_sigma(r), tolerance) << r << " m";
  }
  EXPECT_NEAR(1.0, noise.angle_rad / angle_sigma, tolerance);
}

TEST(NoiseEstimate, RecoversTheLawOfTheSimulatedLidars) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    expect_law(estimate_noise({seen_by(1, 2000, 0.0, random)}, 1, fallback), 0.06);
  }
}

TEST(NoiseEstimate, TellsTheGrowthAtASlantFromNoiseOfTheDirection) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const NoiseModel straight = estimate_noise({seen_by(1, 2000, 0.2, random)}, 1, fallback);
    const NoiseModel growing = estimate_noise({seen_by(1, 2000, 0.2, random, 0.4)}, 1, fallback);
    EXPECT_NEAR(0.0, straight.slant_growth, 0.1);
    EXPECT_NEAR(0.4, growing.slant_growth, 0.15);
    EXPECT_NEAR(1.0, growing.angle_rad / angle_sigma, 0.1);
    EXPECT_NEAR(1.0, std::sqrt(growing.range_variance(100.0, 0.3)) / (1.28 * range_sigma(10.0)), 0.06);
  }
}

TEST(NoiseEstimate, IsNotMisledByRoughSurfacesAndOtherLidars) {
  Random random(11);
  PatchSurfels others = seen_by(0, 2000, 1.0, random);
  expect_law(estimate_noise({others, seen_by(1, 2000, 0.3, random), others}, 1, fallback), 0.1);
}

TEST(NoiseEstimate, FallsBackWhereTooLittleWasSeen) {
  Random random(12);
  const NoiseModel few = estimate_noise({seen_by(1, 59, 0.0, random)}, 1, fallback);
  EXPECT_EQ(fallback.range_m, few.range_m);
  EXPECT_EQ(fallback.angle_rad, few.angle_rad);
  const NoiseModel none = estimate_noise({seen_by(0, 2000, 0.0, random)}, 1, fallback);
  EXPECT_EQ(fallback.range_m, none.range_m);
  // Many, but all alike: one bin cannot tell three shares apart.
  PatchSurfels alike = seen_by(1, 1, 0.0, random);
  alike.surfels.resize(500, alike.surfels[0]);
  EXPECT_EQ(fallback.range_m, estimate_noise({alike}, 1, fallback).range_m);
}

TEST(NoiseEstimate, IsNeverZeroOrNegative) {
  Random random(13);
  PatchSurfels exact = seen_by(1, 2000, 0.0, random);
  for (Surfel& s : exact.surfels) s.variance = 0.0;
  const NoiseModel noise = estimate_noise({exact}, 1, fallback);
  // Three millimetres are what no LiDAR undercuts.
  EXPECT_EQ(0.003, noise.range_m);
  EXPECT_GE(noise.range_per_m, 0.0);
  EXPECT_GE(noise.angle_rad, 1e-5);
}

}  // namespace
}  // namespace rigcal
