#include "simdata/scene/surface_texture.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/random.h"
#include "simdata/scene/pattern_noise.h"

namespace rigcal::sim {
namespace {

struct Spread {
  double mean_color = 0.0;
  double mean_reflectivity = 0.0;
  double sigma_color = 0.0;
  double correlation = 0.0;
};

// Over a wall of 8 x 5 m made of rectangles of 2 x 2.5 m, looked at with a footprint.
Spread spread_of(const Material& material, double footprint) {
  constexpr int count = 20000;
  Random random(31);
  double c = 0.0, r = 0.0, cc = 0.0, rr = 0.0, cr = 0.0;
  for (int i = 0; i < count; ++i) {
    SurfacePoint point;
    point.p.x() = random.uniform(0.0, 8.0);
    point.p.z() = random.uniform(0.0, 5.0);
    point.normal = Vector3d(0.0, -1.0, 0.0);
    point.surface = static_cast<int>(point.p.x() / 2.0) + 4 * static_cast<int>(point.p.z() / 2.5);
    // Leaves and limbs are many small surfaces.
    if (material.texture == Texture::leaves || material.texture == Texture::cloth) point.surface = i;
    point.place.half = {1.0, 1.25};
    point.place.at = {std::fmod(point.p.x(), 2.0) - 1.0, std::fmod(point.p.z(), 2.5) - 1.25};
    point.footprint = footprint;
    const Look look = look_of(material, point);
    const auto color = static_cast<double>(look.color.mean());
    EXPECT_GE(look.color.minCoeff(), 0.0F);
    EXPECT_LE(look.color.maxCoeff(), 1.0F);
    EXPECT_GT(look.reflectivity, 0.0);
    c += color / count;
    r += look.reflectivity / count;
    cc += color * color / count;
    rr += look.reflectivity * look.reflectivity / count;
    cr += color * look.reflectivity / count;
  }
  Spread spread{c, r, std::sqrt(std::max(0.0, cc - c * c)), 0.0};
  const double sigma_r = std::sqrt(std::max(0.0, rr - r * r));
  if (spread.sigma_color > 0.0 && sigma_r > 0.0) spread.correlation = (cr - c * r) / (spread.sigma_color * sigma_r);
  return spread;
}

Material material_of(const std::string& texture) {
  Material material;
  material.texture = *parse_texture(texture);
  return material;
}

TEST(SurfaceTexture, KeepsTheReflectivityOfTheMaterialOnAverage) {
  for (const std::string& name : texture_names()) {
    const Spread spread = spread_of(material_of(name), 0.003);
    EXPECT_NEAR(1.0, spread.mean_reflectivity, name == "window" || name == "bars" ? 0.3 : 0.12) << name;
    if (name == "plain") continue;
    EXPECT_GT(spread.sigma_color, 0.03 * spread.mean_color) << name;
  }
}

// Information between grey value and reflectivity: there, but not all of it.
TEST(SurfaceTexture, ShowsTheLaserSomethingOfWhatTheEyeSees) {
  for (const char* name : {"brick", "plaster", "concrete", "stone", "paving", "tiles", "boards", "window", "checker"}) {
    const double correlation = std::abs(spread_of(material_of(name), 0.003).correlation);
    EXPECT_GT(correlation, 0.3) << name;
    EXPECT_LT(correlation, std::string(name) == "checker" ? 1.001 : 0.999) << name;
  }
}

TEST(SurfaceTexture, FadesIntoItsMeanWhereThePatternIsFinerThanThePixel) {
  for (const char* name : {"brick", "paving", "tiles", "checker"}) {
    const Spread fine = spread_of(material_of(name), 0.002);
    const Spread coarse = spread_of(material_of(name), 1.0);
    EXPECT_LT(coarse.sigma_color, 0.5 * fine.sigma_color) << name;
    EXPECT_NEAR(fine.mean_color, coarse.mean_color, 0.06 * fine.mean_color) << name;
    EXPECT_NEAR(fine.mean_reflectivity, coarse.mean_reflectivity, 0.06) << name;
  }
}

TEST(SurfaceTexture, ABrickWallHasItsJointsWhereBricksEnd) {
  Material brick = material_of("brick");
  brick.pattern_m = 0.25;
  brick.color = Eigen::Array3f{0.4F, 0.1F, 0.05F};
  const auto blue_at = [&](double along, double up) {
    SurfacePoint point;
    point.p = Vector3d(along, 0.0, up);
    point.normal = Vector3d(0.0, -1.0, 0.0);
    return look_of(brick, point).color.z();
  };
  // Joints are grey, bricks are red: level joints at multiples of 75 mm, upright ones each 250 mm, shifted by half.
  EXPECT_GT(blue_at(0.1, 0.15), 0.25F);
  EXPECT_LT(blue_at(0.1, 0.19), 0.15F);
  EXPECT_GT(blue_at(0.25, 0.19), 0.25F);
  EXPECT_LT(blue_at(0.25, 0.19 + 0.075), 0.15F);
  EXPECT_GT(blue_at(0.125, 0.19 + 0.075), 0.25F);
}

TEST(PatternNoise, LinesCoverTheShareTheyHave) {
  EXPECT_EQ(1.0, line_share(0.0, 1.0, 0.1, 0.01));
  EXPECT_EQ(0.0, line_share(0.5, 1.0, 0.1, 0.01));
  EXPECT_NEAR(0.5, line_share(0.05, 1.0, 0.1, 0.01), 1e-9);
  EXPECT_NEAR(0.5, line_share(-2.95, 1.0, 0.1, 0.01), 1e-9);
  EXPECT_NEAR(0.1, line_share(0.3, 1.0, 0.1, 5.0), 1e-9);
}

TEST(SurfaceTexture, KnowsItsNames) {
  EXPECT_EQ(Texture::boards, parse_texture("boards"));
  EXPECT_FALSE(parse_texture("bricks").has_value());
  EXPECT_EQ(16U, texture_names().size());
}

}  // namespace
}  // namespace rigcal::sim
