#include "simdata/scene/surface_optics.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "simdata/lidar/shot_meter.h"
#include "simdata/scene/scene_shapes.h"

namespace rigcal::sim {
namespace {

constexpr int kShots = 20'000;

/// Five sigma of a share of `shots` throws.
double five_sigma(double share, int shots = kShots) { return 5.0 * std::sqrt(share * (1.0 - share) / shots) + 1e-9; }

/// A wall across x at `distance`.
void add_wall(Scene& scene, double distance, int material) {
  scene.flats.push_back(
      {Vector3d(distance, 0.0, 0.0), 200.0 * Vector3d::UnitY(), 200.0 * Vector3d::UnitZ(), false, material});
}

/// A pane or mirror of 2 x 2 m about (distance, 0, 0), turned by `yaw_deg` out of the way.
Flat upright(double distance, double yaw_deg, int material) {
  const Matrix3d R = exp_so3(to_rad(yaw_deg) * Vector3d::UnitZ());
  return {Vector3d(distance, 0.0, 0.0), R * Vector3d::UnitY(), Vector3d::UnitZ(), false, material};
}

struct Shares {
  double pane = 0.0;  ///< First echo within 10 cm of `near_range`,
  double wall = 0.0;  ///< of `far_range`.
  double both = 0.0;
  double none = 0.0;
};

Shares shares_of(const Scene& scene, const LidarNoise& noise, double near_range, double far_range,
                 const Vector3d& direction = Vector3d::UnitX()) {
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, noise);
  Random random(11);
  Shares shares;
  for (int i = 0; i < kShots; ++i) {
    const Shot shot = meter.measure({}, direction, {}, random);
    const auto is = [&](int echo, double range) {
      return echo < shot.count && std::abs(shot.echoes[static_cast<std::size_t>(echo)].range - range) < 0.1;
    };
    shares.none += shot.count == 0 ? 1.0 / kShots : 0.0;
    shares.pane += is(0, near_range) ? 1.0 / kShots : 0.0;
    shares.wall += is(0, far_range) ? 1.0 / kShots : 0.0;
    shares.both += is(0, near_range) && is(1, far_range) ? 1.0 / kShots : 0.0;
  }
  return shares;
}

TEST(SurfaceOptics, FollowsTheFormulas) {
  EXPECT_NEAR(0.0201, water_reflectance(1.0), 1e-12);
  EXPECT_NEAR(1.0, water_reflectance(0.0), 1e-12);
  EXPECT_NEAR(0.0201 + 0.9799 * std::pow(0.9, 5), water_reflectance(0.1), 1e-12);
  EXPECT_NEAR(1.0, pane_glint(1.0), 1e-12);
  EXPECT_NEAR(std::exp(-1.0), pane_glint(std::cos(to_rad(3.0))), 1e-9);
  EXPECT_LT(pane_glint(std::cos(to_rad(10.0))), 1e-4);
}

TEST(SurfaceOptics, LetsThroughAPaneTheShareThatItSays) {
  Scene scene;
  scene.materials = {{"wall", 60.0}, {"pane", 8.0, 0.8}};
  scene.flats.push_back(upright(5.0, 20.0, 1));
  add_wall(scene, 12.0, 0);
  const Shares slanted = shares_of(scene, LidarNoise::none(), 5.0, 12.0);
  EXPECT_NEAR(0.8, slanted.wall, five_sigma(0.8));
  EXPECT_NEAR(0.2, slanted.none, five_sigma(0.2));
  EXPECT_EQ(0.0, slanted.pane);

  // Head on, what does not go through comes straight back; and the pane is a first echo of what does.
  scene.flats[0] = upright(5.0, 0.0, 1);
  const Shares straight = shares_of(scene, LidarNoise::none(), 5.0, 12.0);
  EXPECT_NEAR(1.0, straight.pane, 1e-6);
  EXPECT_NEAR(0.8, straight.both, five_sigma(0.8));

  // Between the two the glints fade.
  scene.flats[0] = upright(5.0, 3.0, 1);
  const Shares fading = shares_of(scene, LidarNoise::none(), 5.0, 12.0);
  EXPECT_NEAR(std::exp(-1.0), fading.pane, five_sigma(std::exp(-1.0)));
}

TEST(SurfaceOptics, WeakensWhatIsSeenThroughAPane) {
  Scene scene;
  scene.materials = {{"dark", 10.0}, {"pane", 8.0, 0.7}};
  scene.flats.push_back(upright(5.0, 20.0, 1));
  add_wall(scene, 90.0, 0);
  LidarNoise noise = LidarNoise::none();
  noise.range_at_10_percent = 90.0;
  // At the range where half of the shots return, 0.7 of the strength: 0.49 / 1.49 of the 0.7 that go through.
  const double share = 0.7 * 0.49 / 1.49;
  EXPECT_NEAR(share, shares_of(scene, noise, 5.0, 90.0).wall, five_sigma(share));
}

TEST(SurfaceOptics, PutsGhostsExactlyBehindAMirror) {
  Scene scene;
  scene.materials = {{"wall", 60.0}, {"mirror", 8.0, 0.0, 0.9}};
  scene.flats.push_back(upright(5.0, 25.0, 1));
  add_wall(scene, -8.0, 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::none());
  const Vector3d normal = exp_so3(to_rad(25.0) * Vector3d::UnitZ()) * Vector3d::UnitX();
  const double offset = normal.dot(Vector3d(5.0, 0.0, 0.0));
  Random random(12);
  int ghosts = 0;
  for (int i = 0; i < kShots; ++i) {
    const double sideways = random.uniform(-0.12, 0.12);
    const double upwards = random.uniform(-0.12, 0.12);
    const Vector3d direction = Vector3d(1.0, sideways, upwards).normalized();
    const Shot shot = meter.measure({}, direction, {}, random);
    ASSERT_EQ(1, shot.count);
    const Vector3d point = shot.echoes[0].range * shot.direction;
    const double behind = normal.dot(point) - offset;
    if (behind < 0.01) continue;  // what lies on the mirror scatters
    ++ghosts;
    const Vector3d image = point - 2.0 * behind * normal;
    ASSERT_NEAR(-8.0, image.x(), 1e-9);
  }
  EXPECT_NEAR(0.9, static_cast<double>(ghosts) / kShots, five_sigma(0.9));
}

TEST(SurfaceOptics, MirrorsInWaterWhatStandsBehindIt) {
  Scene scene;
  scene.materials = {{"wall", 60.0}, {"water", 30.0, 0.0, 0.0, 0.8}};
  scene.has_ground = true;
  scene.ground_height = -1.3;
  scene.ground_material = 1;
  add_wall(scene, 20.0, 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::none());
  for (const double slope : {0.08, 0.2, 0.5}) {
    const Vector3d direction = Vector3d(1.0, 0.0, -slope).normalized();
    const double mirrored = 0.8 * water_reflectance(-direction.z());
    Random random(13);
    int ghosts = 0;
    for (int i = 0; i < kShots; ++i) {
      const Shot shot = meter.measure({}, direction, {}, random);
      ASSERT_EQ(1, shot.count);
      const Vector3d point = shot.echoes[0].range * direction;
      if (point.z() > -1.301) {
        ASSERT_NEAR(-1.3, point.z(), 1e-9);
        continue;
      }
      ++ghosts;
      ASSERT_NEAR(20.0, point.x(), 1e-9);  // the wall's image stands on its head below it
    }
    EXPECT_NEAR(mirrored, static_cast<double>(ghosts) / kShots, five_sigma(mirrored)) << slope;
  }
}

TEST(SurfaceOptics, LosesWetGroundAtGrazingIncidence) {
  Scene scene;
  scene.materials = {{"wet", 34.0, 0.0, 0.0, 0.9}, {"dry", 34.0}};
  scene.has_ground = true;
  scene.ground_height = -1.3;
  LidarNoise noise = LidarNoise::none();
  noise.range_at_10_percent = 90.0;
  const Vector3d direction = Vector3d(1.0, 0.0, -0.05).normalized();  // ground at 26 m
  const double range = 1.3 / -direction.z();
  const double cos = -direction.z();
  const double mirrored = 0.9 * water_reflectance(cos);
  const auto returned = [&](double left) {
    const double strength = 90.0 * 90.0 / (range * range) * 3.4 * cos * left;
    return strength * strength / (1.0 + strength * strength);
  };
  const double wet = (1.0 - mirrored) * returned((1.0 - mirrored) * (1.0 - mirrored) * 0.55);
  EXPECT_NEAR(wet, shares_of(scene, noise, range, 1e9, direction).pane, five_sigma(wet));
  scene.ground_material = 1;
  EXPECT_NEAR(returned(1.0), shares_of(scene, noise, range, 1e9, direction).pane, five_sigma(returned(1.0)));
  EXPECT_LT(wet, 0.2);
  EXPECT_GT(returned(1.0), 0.6);
}

TEST(SurfaceOptics, EndsBetweenTwoMirrors) {
  Scene scene;
  scene.materials = {{"mirror", 8.0, 0.0, 1.0}};
  add_wall(scene, 2.0, 0);
  add_wall(scene, -2.0, 0);
  const RayCaster caster(scene);
  const ShotMeter meter(caster, scene.materials, LidarNoise::none());
  Random random(14);
  EXPECT_EQ(0, meter.measure({}, Vector3d::UnitX(), {}, random).count);
}

}  // namespace
}  // namespace rigcal::sim
