#include "simdata/rig/random_rig.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "simdata/scene/ray_caster.h"
#include "simdata/scene/scene_file.h"

namespace rigcal::sim {
namespace {

LightRig thrown(const std::string& scene, std::uint64_t seed, const RandomMounting& mounting = {}) {
  LightRigOptions options;
  options.seed = seed;
  options.turntable.stops = 5;
  options.shots_per_patch = 1500;
  options.with_noise = false;
  const auto light = make_random_rig(*load_scene(scene), options, mounting);
  EXPECT_TRUE(light.has_value());
  return *light;
}

TEST(RandomRig, TurnsAboutItsAxisAsTheTruthHasIt) {
  const LightRig rig = thrown("room", 4);
  ASSERT_EQ(rig.T_G_base.size(), 5U);
  EXPECT_LT((rig.T_G_base[0].matrix() - SE3{}.matrix()).norm(), 1e-12);
  for (const SE3& T : rig.T_G_base) {
    // Each stop is a little off the turn.
    EXPECT_LT((T * rig.axis_point - rig.axis_point).norm(), 0.003);
    EXPECT_LT((T.R * rig.axis - rig.axis).norm(), 0.002);
  }
  ASSERT_EQ(rig.step_rotations.size(), 4U);
  EXPECT_GT(rig.step_rotations[0].normalized().dot(rig.axis), 0.999);
}

TEST(RandomRig, HasPointsThatTheTruthLaysOnOneScene) {
  const LightRig rig = thrown("room", 5);
  ASSERT_EQ(rig.rig.sensors.size(), 4U);
  EXPECT_EQ(rig.rig.base_sensor().name, "avia");
  ASSERT_EQ(rig.patches.size(), 20U);
  // All points of a room lie within its walls, 10 x 7 x 3 m, wherever they are seen from.
  Eigen::AlignedBox3d room;
  for (const Patch& patch : rig.patches) {
    const SE3 T =
        rig.T_G_base[static_cast<std::size_t>(patch.stop)] * rig.T_base_sensor[static_cast<std::size_t>(patch.sensor)];
    for (const Point& p : patch.points) room.extend(T * Vector3d(p.x, p.y, p.z));
  }
  EXPECT_LT(room.diagonal().norm(), 20.0);
}

TEST(RandomRig, MountsLidarsThatLookAtTheSkyOnlyWhereThatIsAskedFor) {
  RandomMounting anyhow;
  anyhow.sees_all_directions = false;
  std::size_t few = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    for (const Patch& patch : thrown("courtyard", seed).patches) EXPECT_GT(patch.points.size(), 20U);
    for (const Patch& patch : thrown("courtyard", seed, anyhow).patches) few += patch.points.size() < 20 ? 1 : 0;
  }
  EXPECT_GT(few, 5U);
}

TEST(RandomRig, MountsLidarsThatSeeNothingAlikeOnlyWhereThatIsAskedFor) {
  // In a room 3 m high: some see the floor but not the ceiling, some the other way round, and nobody both.
  const auto apart = [](const LightRig& rig) {
    std::vector<double> low(4, 1e9);
    std::vector<double> high(4, -1e9);
    for (const Patch& patch : rig.patches) {
      const auto i = static_cast<std::size_t>(patch.sensor);
      const SE3 T = rig.T_G_base[static_cast<std::size_t>(patch.stop)] * rig.T_base_sensor[i];
      for (const Point& p : patch.points) {
        const double height = rig.axis.dot(T * Vector3d(p.x, p.y, p.z));
        low[i] = std::min(low[i], height);
        high[i] = std::max(high[i], height);
      }
    }
    const double room = *std::max_element(high.begin(), high.end()) - *std::min_element(low.begin(), low.end());
    std::size_t sees_floor = 0;
    std::size_t sees_ceiling = 0;
    std::size_t sees_both = 0;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool floor = low[i] < *std::min_element(low.begin(), low.end()) + 0.3;
      const bool ceiling = high[i] > *std::max_element(high.begin(), high.end()) - 0.3;
      sees_floor += floor && !ceiling ? 1 : 0;
      sees_ceiling += ceiling && !floor ? 1 : 0;
      sees_both += floor && ceiling ? 1 : 0;
    }
    return room > 2.5 && sees_both == 0 && sees_floor > 0 && sees_ceiling > 0;
  };
  RandomMounting sharing;
  sharing.shares_surfaces = true;
  int apart_anyhow = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    EXPECT_FALSE(apart(thrown("room", seed, sharing))) << seed;
    apart_anyhow += apart(thrown("room", seed)) ? 1 : 0;
  }
  EXPECT_GT(apart_anyhow, 0);
}

}  // namespace
}  // namespace rigcal::sim
