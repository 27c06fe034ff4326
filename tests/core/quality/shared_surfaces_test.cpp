#include "core/quality/shared_surfaces.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

namespace rigcal {
namespace {

// Walls that two LiDARs (or all three) see, each LiDAR half a metre from the next along the wall.
PlaneFeature wall(const Vector3d& normal, const Vector3d& along, const std::vector<int>& lidars) {
  PlaneFeature feature;
  feature.normal_G = normal;
  for (const int lidar : lidars) {
    PlaneObservation o;
    o.lidar = lidar;
    o.N = 100.0;
    o.mean = 4.0 * normal + 0.5 * lidar * along;
    const Vector3d across = normal.cross(along);
    o.scatter = o.N * (0.04 * along * along.transpose() + 0.04 * across * across.transpose());
    o.offset_variance = 1e-6;
    feature.observations.push_back(o);
  }
  return feature;
}

RigState rig_of(double shift_m) {
  RigState state;
  state.T_G_base.resize(1);
  state.T_base_sensor.resize(3);
  state.T_base_sensor[1].t.x() = shift_m;
  return state;
}

TEST(SharedSurfaces, AreAsThickAsOneLidarStandsOffTheOther) {
  const Vector3d x = Vector3d::UnitX();
  const Vector3d y = Vector3d::UnitY();
  PlaneFeature merged = wall(x, y, {0, 1});
  merged.merged = true;
  const std::vector<PlaneFeature> features{wall(x, y, {0, 1, 2}), wall(y, x, {0, 1}), wall(x, y, {0}), merged};
  const auto found = shared_surfaces(features, rig_of(0.3), rig_of(0.002), {"avia", "left", "right"});
  ASSERT_EQ(found.size(), 4U);
  // The shift is across the first wall and along the second.
  EXPECT_EQ(found[0].first + " " + found[0].second, "avia left");
  EXPECT_EQ(found[0].surfaces, 2U);
  EXPECT_NEAR(found[0].before_m, 0.3 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(found[0].after_m, 0.002 / std::sqrt(2.0), 1e-5);
  EXPECT_EQ(found[1].first + " " + found[1].second, "avia right");
  EXPECT_NEAR(found[1].before_m, 0.0, 1e-5);
  EXPECT_EQ(found[2].first + " " + found[2].second, "left right");
  EXPECT_NEAR(found[2].before_m, 0.3, 1e-5);
  EXPECT_EQ(found[3].first, "");
  EXPECT_EQ(found[3].surfaces, 4U);
  EXPECT_NEAR(found[3].before_m, 0.3 / std::sqrt(2.0), 1e-5);
}

TEST(SharedSurfaces, AreNoneWhereNothingIsShared) {
  const std::vector<PlaneFeature> features{wall(Vector3d::UnitX(), Vector3d::UnitY(), {0})};
  EXPECT_TRUE(shared_surfaces(features, rig_of(0.3), rig_of(0.0), {"avia", "left", "right"}).empty());
}

}  // namespace
}  // namespace rigcal
