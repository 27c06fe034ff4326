#include "simdata/lidar/shot_meter.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/lidar/beam_wobble.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

Scene wall_at(double distance, double reflectivity) {
  Scene scene;
  scene.materials = {{"wall", reflectivity}};
  scene.flats.push_back({Vector3d(distance, 0.0, 0.0), 100.0 * Vector3d::UnitY(), 100.0 * Vector3d::UnitZ(), false, 0});
  return scene;
}

TEST(ShotMeter, ScattersRangesAsItSays) {
  const Scene scene = wall_at(20.0, 60.0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::of(LidarModel::livox_avia));
  Random random(1);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.echoes[0].range <= 0.0) continue;
    sum += shot.echoes[0].range - 20.0;
    squares += (shot.echoes[0].range - 20.0) * (shot.echoes[0].range - 20.0);
    ++count;
  }
  // 15 mm + 20 x 0.25 mm; five sigma of the mean and of the standard deviation of 20000.
  EXPECT_NEAR(0.0, sum / count, 5.0 * 0.020 / std::sqrt(20000.0));
  EXPECT_NEAR(0.020, std::sqrt(squares / count), 5.0 * 0.020 / std::sqrt(40000.0));
}

TEST(ShotMeter, ScattersDirectionsByTwoHundredthsOfADegree) {
  const Scene scene = wall_at(10.0, 60.0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::of(LidarModel::livox_avia));
  Random random(2);
  double squares = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.echoes[0].range <= 0.0) continue;
    squares += shot.direction.y() * shot.direction.y() + shot.direction.z() * shot.direction.z();
    ++count;
  }
  EXPECT_NEAR(0.02, to_deg(std::sqrt(squares / (2.0 * count))), 0.02 * 5.0 / std::sqrt(80000.0));
}

double share_returned(double distance, double reflectivity, const LidarNoise& noise) {
  const Scene scene = wall_at(distance, reflectivity);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, noise);
  Random random(3);
  int returned = 0;
  for (int i = 0; i < 4000; ++i)
    returned += meter.measure({}, Vector3d::UnitX(), {}, random).echoes[0].range > 0.0 ? 1 : 0;
  return returned / 4000.0;
}

TEST(ShotMeter, LosesShotsWithRangeAndDarkness) {
  // Half at the data sheet's range of a 10 % target: five sigma of 4000 are 4 %.
  EXPECT_NEAR(0.5, share_returned(90.0, 10.0, LidarNoise::of(LidarModel::livox_mid40)), 0.04);
  EXPECT_GT(share_returned(10.0, 10.0, LidarNoise::of(LidarModel::livox_mid40)), 0.98);
  EXPECT_GT(share_returned(90.0, 80.0, LidarNoise::of(LidarModel::livox_mid40)), 0.95);
  EXPECT_EQ(0.0, share_returned(0.8, 50.0, LidarNoise::of(LidarModel::livox_mid40)));  // nearer than the least range
}

TEST(ShotMeter, PutsPointsBetweenTwoSurfacesAtADepthEdge) {
  Scene scene = wall_at(10.3, 60.0);
  // A board 30 cm before the wall whose upper edge the beam straddles: 0.28 degrees are 49 mm there.
  add_box(scene, {Matrix3d::Identity(), Vector3d(10.0, 0.0, -1.0 + 0.005)}, Vector3d(0.02, 4.0, 2.0), 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::of(LidarModel::livox_avia));
  Random random(4);
  int between = 0;
  int tagged = 0;
  for (int i = 0; i < 5000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.echoes[0].range > 10.08 && shot.echoes[0].range < 10.22) ++between;
    if ((shot.echoes[0].tag & 0x03) != 0) ++tagged;
  }
  // A fifth look twice, about two in five of them meet the wall, half of these fall into the middle half.
  EXPECT_GT(between, 5000 * 0.2 * 0.4 * 0.25);
  EXPECT_GT(tagged, 50);
  EXPECT_LT(between, 600);
}

TEST(ShotMeter, GivesASecondEchoWhereSurfacesAreFarApart) {
  Scene scene = wall_at(15.0, 60.0);
  add_box(scene, {Matrix3d::Identity(), Vector3d(10.0, 0.0, -1.0 + 0.005)}, Vector3d(0.02, 4.0, 2.0), 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::of(LidarModel::livox_avia));
  Random random(5);
  int second = 0;
  for (int i = 0; i < 2000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.echoes[0].range > 0.0) {
      EXPECT_NEAR(10.0, shot.echoes[0].range, 0.15);
    }
    if (shot.echoes[1].range > 0.0) {
      EXPECT_NEAR(15.0, shot.echoes[1].range, 0.15);
      ++second;
    }
  }
  EXPECT_GT(second, 50);
}

// Share of a disc that lies beyond a line at `h` of its radius.
double beyond(double h) {
  if (h <= -1.0) return 1.0;
  if (h >= 1.0) return 0.0;
  return (std::acos(h) - h * std::sqrt(1.0 - h * h)) / pi;
}

TEST(ShotMeter, HasAFootprintAsHighAndAsWideAsTheBeam) {
  // A quarter plane at 10 m before a wall at 30 m: its edges are crossed as far from the beam as the beam is wide.
  LidarNoise noise = LidarNoise::none();
  noise.divergence_y_rad = LidarNoise::of(LidarModel::livox_avia).divergence_y_rad;
  noise.divergence_z_rad = LidarNoise::of(LidarModel::livox_avia).divergence_z_rad;
  noise.second_ray_share = 1.0;
  EXPECT_NEAR(0.03, to_deg(noise.divergence_y_rad), 1e-12);
  EXPECT_NEAR(0.28, to_deg(noise.divergence_z_rad), 1e-12);
  constexpr int shots = 4000;
  for (const bool upright : {false, true}) {
    const double half_width = 0.5 * (upright ? noise.divergence_y_rad : noise.divergence_z_rad);
    Scene scene = wall_at(30.0, 60.0);
    const Vector3d corner = upright ? Vector3d(10.0, 50.0, 0.0) : Vector3d(10.0, 0.0, 50.0);
    scene.flats.push_back({corner, 50.0 * Vector3d::UnitY(), 50.0 * Vector3d::UnitZ(), false, 0});
    const RayCaster caster(scene);
    const ShotMeter meter(caster, scene.materials, noise);
    for (const double h : {-1.2, -0.7, -0.3, 0.1, 0.5, 0.9, 1.2}) {
      // The beam's centre is h half widths off the edge, on the side of the wall where h > 0.
      const double off = -h * half_width;
      const Vector3d direction = Vector3d(1.0, upright ? off : 0.0, upright ? 0.0 : off).normalized();
      Random random(6);
      int two = 0;
      for (int i = 0; i < shots; ++i) {
        const Shot shot = meter.measure({}, direction, {}, random);
        ASSERT_GE(shot.count, 1);
        if (shot.count < 2) continue;
        ++two;
        ASSERT_NEAR(10.0, shot.echoes[0].range, 0.01);
        ASSERT_NEAR(30.0, shot.echoes[1].range, 0.01);
        ASSERT_EQ(0x10, shot.echoes[0].tag);
        ASSERT_EQ(0x20, shot.echoes[1].tag);
        ASSERT_EQ(h > 0.0 ? 1 : 0, shot.strongest);
        ASSERT_EQ(shot.echoes[h > 0.0 ? 1 : 0].range, shot.single(false).range);
        ASSERT_EQ(shot.echoes[0].range, shot.single(true).range);
        ASSERT_EQ(0x10, shot.single(false).tag);
      }
      const double share = beyond(std::abs(h));
      EXPECT_NEAR(share, two / static_cast<double>(shots), 5.0 * std::sqrt(share * (1.0 - share) / shots) + 1e-9)
          << h << upright;
    }
  }
}

TEST(ShotMeter, GivesUpToThreeEchoesInTheOrderOfTheirRange) {
  Scene scene = wall_at(30.0, 60.0);
  // Slats at 20 m and 10 m that each take a third of the beam's height: 49 mm at 10 m.
  scene.flats.push_back({Vector3d(20.0, 0.0, 0.065), 5.0 * Vector3d::UnitY(), 0.05 * Vector3d::UnitZ(), false, 0});
  scene.flats.push_back({Vector3d(10.0, 0.0, -0.058), 5.0 * Vector3d::UnitY(), 0.05 * Vector3d::UnitZ(), false, 0});
  LidarNoise noise = LidarNoise::none();
  noise.divergence_z_rad = to_rad(0.28);
  noise.second_ray_share = 1.0;
  const RayCaster caster(scene);
  Random random(7);
  for (const int looks : {1, 2}) {
    const ShotMeter meter(caster, scene.materials, noise, looks);
    int with[4] = {0, 0, 0, 0};
    for (int i = 0; i < 5000; ++i) {
      const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
      ASSERT_GE(shot.count, 1);
      ++with[shot.count];
      for (int e = 0; e < shot.count; ++e) {
        const Echo& echo = shot.echoes[static_cast<std::size_t>(e)];
        ASSERT_EQ((e + 1) << 4, echo.tag);
        if (e > 0) {
          ASSERT_GT(echo.range, shot.echoes[static_cast<std::size_t>(e) - 1].range + 5.0);
        }
      }
      ASSERT_NEAR(30.0, shot.echoes[static_cast<std::size_t>(shot.strongest)].range, 0.1);
    }
    EXPECT_GT(with[2], 500);
    if (looks == 1) {
      EXPECT_EQ(0, with[3]);
    } else {
      EXPECT_GT(with[3], 200);
    }
  }
}

TEST(ShotMeter, IsOffByItsBiasAndOnDarkTargetsByMore) {
  LidarNoise noise = LidarNoise::of(LidarModel::livox_avia);
  noise.range_bias = -0.012;
  noise.dark_bias = 0.02;
  for (const double reflectivity : {10.0, 50.0, 100.0, 140.0}) {
    const Scene scene = wall_at(8.0, reflectivity);
    const RayCaster caster(scene);
    const ShotMeter meter(caster, scene.materials, noise);
    Random random(8);
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < 20000; ++i) {
      const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
      if (shot.count == 0) continue;
      sum += shot.echoes[0].range - 8.0;
      ++count;
    }
    const double expected = -0.012 + 0.02 * (1.0 - std::min(reflectivity, 100.0) / 100.0);
    EXPECT_NEAR(expected, sum / count, 5.0 * 0.017 / std::sqrt(count)) << reflectivity;
  }
}

TEST(BeamWobble, GoesRoundACone) {
  const BeamWobble wobble{to_rad(0.05), 40.0, 0.3};
  Vector3d sum = Vector3d::Zero();
  for (int i = 0; i < 100; ++i) {
    const Vector3d turn = log_so3(wobble.at(i / 4000.0));
    EXPECT_NEAR(to_rad(0.05), turn.norm(), 1e-9);
    EXPECT_NEAR(0.0, turn.x(), 1e-9);
    sum += turn;
  }
  EXPECT_LT(sum.norm(), 1e-9);  // one turn of the prism
  EXPECT_NEAR(0.0, (wobble.at(1.0) - wobble.at(1.0 + 1.0 / 40.0)).norm(), 1e-9);
}

TEST(ShotMeter, RoundsPointsToTheMillimetresOfTheWire) {
  const Point point = to_point(Vector3d(0.6, 0.0, -0.8), {1.23456, 7, 0x10});
  EXPECT_FLOAT_EQ(0.741F, point.x);
  EXPECT_FLOAT_EQ(-0.988F, point.z);
  EXPECT_EQ(7, point.reflectivity);
}

}  // namespace
}  // namespace rigcal::sim
