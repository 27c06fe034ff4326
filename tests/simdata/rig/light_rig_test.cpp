#include "simdata/rig/light_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/base/parallel.h"
#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::sim {
namespace {

LightRigOptions small_run(std::uint64_t seed) {
  LightRigOptions options;
  options.seed = seed;
  options.turntable.stops = 4;
  options.shots_per_patch = 2000;
  return options;
}

LightRig rig_in(const std::string& scene_name, const LightRigOptions& options) {
  const auto scene = load_scene(scene_name);
  EXPECT_TRUE(scene.has_value());
  auto light = make_light_rig(*scene, options);
  EXPECT_TRUE(light.has_value());
  return *std::move(light);
}

TEST(LightRig, GivesTheSameBitsForAnyNumberOfThreads) {
  set_thread_count(1);
  const LightRig one = rig_in("courtyard", small_run(3));
  set_thread_count(3);
  const LightRig three = rig_in("courtyard", small_run(3));
  set_thread_count(2);
  ASSERT_EQ(one.patches.size(), three.patches.size());
  for (std::size_t i = 0; i < one.patches.size(); ++i) {
    ASSERT_EQ(one.patches[i].points.size(), three.patches[i].points.size());
    EXPECT_EQ(0, std::memcmp(one.patches[i].points.data(), three.patches[i].points.data(),
                             one.patches[i].points.size() * sizeof(Point)));
  }
}

TEST(LightRig, PutsExactPointsOnTheSurfacesOfTheSceneByItsTruth) {
  auto scene = load_scene("courtyard");
  ASSERT_TRUE(scene.has_value());
  scene->people.clear();  // they walk on while the patch is taken
  LightRigOptions options = small_run(5);
  options.with_noise = false;
  const auto light = make_light_rig(*scene, options);
  ASSERT_TRUE(light.has_value());
  const RayCaster caster(*scene);
  // World G is the base at the first stop; the scene's own frame is found again from the same seed.
  const auto simulated =
      make_simulated_rig(light->rig, scene->T_scene_table, options.turntable, options.mount_error, 5);
  ASSERT_TRUE(simulated.has_value());
  const SE3 T_scene_G = simulated->motion.T_scene_G();
  std::size_t off = 0;
  std::size_t all = 0;
  for (const Patch& patch : light->patches) {
    const SE3 T_G_sensor = light->T_G_base[static_cast<std::size_t>(patch.stop)] *
                           light->T_base_sensor[static_cast<std::size_t>(patch.sensor)];
    const SE3 T_scene_sensor = T_scene_G * T_G_sensor;
    for (const Point& point : patch.points) {
      const Vector3d p(point.x, point.y, point.z);
      const auto hit = caster.cast(T_scene_sensor.t, T_scene_sensor.R * p.normalized(), {}, 500.0);
      // Half a millimetre of rounding turns the ray a little: a few rays slip past an edge or graze.
      if (!hit || std::abs(hit->range - p.norm()) > 0.01) ++off;
      ++all;
    }
  }
  EXPECT_GT(all, 4U * 4U * 1200U);
  EXPECT_LT(static_cast<double>(off), 0.02 * static_cast<double>(all));
}

TEST(LightRig, IsOffItsRigFileByExactlyTheMountError) {
  LightRigOptions options = small_run(7);
  options.mount_error = {0.35, 12.0};
  const LightRig light = rig_in("room", options);
  for (std::size_t i = 1; i < light.T_base_sensor.size(); ++i) {
    const SE3& nominal = *light.rig.sensors[i].initial_T_base_sensor;
    EXPECT_NEAR(0.35, (nominal.t - light.T_base_sensor[i].t).norm(), 1e-9);
    EXPECT_NEAR(12.0, to_deg(rotation_distance(nominal.R, light.T_base_sensor[i].R)), 1e-6);
  }
  EXPECT_EQ(0.0, (light.T_base_sensor[0].R - Matrix3d::Identity()).norm());
}

TEST(LightRig, SaysTheTurnOfEveryStepAsAGyroWould) {
  const LightRig light = rig_in("sparse", small_run(11));
  ASSERT_EQ(3U, light.step_rotations.size());
  for (std::size_t k = 0; k < 3; ++k) {
    const Matrix3d step = light.T_G_base[k].R.transpose() * light.T_G_base[k + 1].R;
    // Five sigma of 0.02 degrees, three axes.
    EXPECT_LT(to_deg((light.step_rotations[k] - log_so3(step)).norm()), 5.0 * 0.02 * std::sqrt(3.0));
    // 90 degrees a step, each drawn with 1.2 degrees.
    EXPECT_NEAR(90.0, to_deg(light.step_rotations[k].norm()), 6.0);
  }
}

TEST(LightRig, CreepsThroughItsPatches) {
  auto scene = load_scene("room");
  ASSERT_TRUE(scene.has_value());
  scene->people.clear();
  LightRigOptions options = small_run(9);
  options.with_noise = false;
  options.mount_error = {0.0, 0.0};
  const auto still = make_light_rig(*scene, options);
  options.turntable.creep_rad_per_s = 2e-3;
  const auto creeping = make_light_rig(*scene, options);
  ASSERT_TRUE(still.has_value() && creeping.has_value());
  // Points of the creeping rig, brought back to the pose of the middle, lie where the scene is seen: the range error of
  // a point grows with its distance in time, to 2 mrad at either end; at 5 m on slanted walls some millimetres.
  std::size_t moved = 0;
  const auto& a = still->patches[1].points;
  const auto& b = creeping->patches[1].points;
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) moved += std::abs(a[i].x - b[i].x) > 1.5e-3F ? 1 : 0;
  EXPECT_GT(moved, a.size() / 10);
  EXPECT_NEAR(0.0, creeping->T_G_base[0].t.norm(), 1e-12);
}

// One patch of both would be of two places, of which the truth could have only one.
TEST(LightRig, TakesAPatchBeforeABumpAndOneAfterIt) {
  LightRigOptions options = small_run(13);
  options.turntable.bumps = {{1, 0.8, to_rad(2.0)}, {3, 1e-3, to_rad(2.0)}};
  const LightRig light = rig_in("room", options);
  const LightRig quiet = rig_in("room", small_run(13));
  ASSERT_EQ(light.T_G_base.size(), 5U);
  ASSERT_EQ(light.patches.size(), 5U * light.lidars.size());
  EXPECT_EQ(light.step_rotations.size(), 4U);
  EXPECT_NEAR(to_deg(rotation_distance(light.T_G_base[1].R, light.T_G_base[2].R)), 2.0, 1e-6);
  EXPECT_EQ(light.T_G_base[1].R, quiet.T_G_base[1].R);
  EXPECT_EQ(light.T_G_base[3].R, quiet.T_G_base[2].R);
  EXPECT_NEAR(to_deg(rotation_distance(light.T_G_base[4].R, quiet.T_G_base[3].R)), 2.0, 1e-6) << "almost all of it";
  for (std::size_t i = 0; i < light.patches.size(); ++i) {
    EXPECT_EQ(light.patches[i].stop, static_cast<int>(i / light.lidars.size()));
    EXPECT_GT(light.patches[i].points.size(), 1000U);
  }
}

TEST(LightRig, RefusesALidarWhoseScanIsNotKnown) {
  Rig rig = nominal_rig();
  rig.sensors[1].lidar->model = LidarModel::other;
  const auto scene = load_scene("room");
  const auto light = make_light_rig(*scene, small_run(1), rig);
  ASSERT_FALSE(light.has_value());
  EXPECT_NE(std::string::npos, light.error().message().find("mid100_left"));
}

}  // namespace
}  // namespace rigcal::sim
