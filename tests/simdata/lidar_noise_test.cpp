#include "simdata/lidar_noise.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/scene_shapes.h"

namespace rigcal::sim {
namespace {

Scene wall_at(double distance, double reflectivity) {
  Scene scene;
  scene.materials = {{"wall", reflectivity}};
  scene.flats.push_back({Vector3d(distance, 0.0, 0.0), 100.0 * Vector3d::UnitY(), 100.0 * Vector3d::UnitZ(), false, 0});
  return scene;
}

TEST(LidarNoise, ScattersRangesAsItSays) {
  const Scene scene = wall_at(20.0, 60.0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::avia());
  Random random(1);
  double sum = 0.0;
  double squares = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.first.range <= 0.0) continue;
    sum += shot.first.range - 20.0;
    squares += (shot.first.range - 20.0) * (shot.first.range - 20.0);
    ++count;
  }
  // 15 mm + 20 x 0.25 mm; five sigma of the mean and of the standard deviation of 20000.
  EXPECT_NEAR(0.0, sum / count, 5.0 * 0.020 / std::sqrt(20000.0));
  EXPECT_NEAR(0.020, std::sqrt(squares / count), 5.0 * 0.020 / std::sqrt(40000.0));
}

TEST(LidarNoise, ScattersDirectionsByTwoHundredthsOfADegree) {
  const Scene scene = wall_at(10.0, 60.0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::avia());
  Random random(2);
  double squares = 0.0;
  int count = 0;
  for (int i = 0; i < 20000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.first.range <= 0.0) continue;
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
  for (int i = 0; i < 4000; ++i) returned += meter.measure({}, Vector3d::UnitX(), {}, random).first.range > 0.0 ? 1 : 0;
  return returned / 4000.0;
}

TEST(LidarNoise, LosesShotsWithRangeAndDarkness) {
  // Half at the data sheet's range of a 10 % target: five sigma of 4000 are 4 %.
  EXPECT_NEAR(0.5, share_returned(90.0, 10.0, LidarNoise::mid40()), 0.04);
  EXPECT_GT(share_returned(10.0, 10.0, LidarNoise::mid40()), 0.98);
  EXPECT_GT(share_returned(90.0, 80.0, LidarNoise::mid40()), 0.95);
  EXPECT_EQ(0.0, share_returned(0.8, 50.0, LidarNoise::mid40()));  // nearer than the least range
}

TEST(LidarNoise, PutsPointsBetweenTwoSurfacesAtADepthEdge) {
  Scene scene = wall_at(10.3, 60.0);
  // A board 30 cm before the wall whose upper edge the beam straddles: 0.28 degrees are 49 mm there.
  add_box(scene, {Matrix3d::Identity(), Vector3d(10.0, 0.0, -1.0 + 0.005)}, Vector3d(0.02, 4.0, 2.0), 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::avia());
  Random random(4);
  int between = 0;
  int tagged = 0;
  for (int i = 0; i < 5000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.first.range > 10.08 && shot.first.range < 10.22) ++between;
    if ((shot.first.tag & 0x03) != 0) ++tagged;
  }
  // A fifth look twice, about two in five of them meet the wall, half of these fall into the middle half.
  EXPECT_GT(between, 5000 * 0.2 * 0.4 * 0.25);
  EXPECT_GT(tagged, 50);
  EXPECT_LT(between, 600);
}

TEST(LidarNoise, GivesASecondEchoWhereSurfacesAreFarApart) {
  Scene scene = wall_at(15.0, 60.0);
  add_box(scene, {Matrix3d::Identity(), Vector3d(10.0, 0.0, -1.0 + 0.005)}, Vector3d(0.02, 4.0, 2.0), 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::avia());
  Random random(5);
  int second = 0;
  for (int i = 0; i < 2000; ++i) {
    const Shot shot = meter.measure({}, Vector3d::UnitX(), {}, random);
    if (shot.first.range > 0.0) {
      EXPECT_NEAR(10.0, shot.first.range, 0.15);
    }
    if (shot.second.range > 0.0) {
      EXPECT_NEAR(15.0, shot.second.range, 0.15);
      ++second;
    }
  }
  EXPECT_GT(second, 50);
}

TEST(LidarNoise, RoundsPointsToTheMillimetresOfTheWire) {
  const Point point = to_point(Vector3d(0.6, 0.0, -0.8), {1.23456, 7, 0x10});
  EXPECT_FLOAT_EQ(0.741F, point.x);
  EXPECT_FLOAT_EQ(-0.988F, point.z);
  EXPECT_EQ(7, point.reflectivity);
}

}  // namespace
}  // namespace rigcal::sim
