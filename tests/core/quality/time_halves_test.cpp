#include "core/quality/time_halves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

constexpr int stops = 8;
constexpr int lidars = 3;
constexpr double sigma_m = 0.01;

// Three LiDARs that see planes all around at eight stops; `slip` moves the last of them from the fifth stop on.
struct Rig3 {
  RigState state;
  std::vector<PlaneFeature> features;
  ParameterLayout layout{stops, lidars};
  AdjustOptions options;

  Rig3(std::uint64_t seed, const SE3& slip) {
    Random random(seed);
    state.T_G_base.emplace_back();
    for (int j = 1; j < stops; ++j) state.T_G_base.push_back(random_pose(random, 0.6, 0.2));
    state.T_base_sensor = {SE3{}, random_pose(random, 0.8, 0.2), random_pose(random, 0.8, 0.2)};
    features = make_plane_features(state, 40, 60, sigma_m, random);
    for (PlaneFeature& feature : features) {
      for (PlaneObservation& o : feature.observations) {
        o.offset_variance = sigma_m * sigma_m / o.N;
        // What the sensor sees of a fixed world where it stands at T slip.
        if (o.lidar != 2 || o.stop < stops / 2) continue;
        o.mean = slip.inverse() * o.mean;
        o.scatter = slip.R.transpose() * o.scatter * slip.R;
      }
    }
    for (int j = 1; j < stops; ++j) layout.free_stop(j);
    for (int i = 1; i < lidars; ++i) layout.free_lidar(i);
    adjust(features, layout, options, state);
  }
  [[nodiscard]] std::vector<TimeHalves> halves() const {
    return compare_time_halves({features, state, layout, options});
  }
};

TEST(TimeHalves, OfWhatStaysDifferByNoMoreThanTheirNoise) {
  double sum = 0.0;
  constexpr int runs = 40;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const std::vector<TimeHalves> halves = Rig3(seed, SE3{}).halves();
    ASSERT_EQ(halves.size(), 3U);
    for (const TimeHalves& each : halves) {
      ASSERT_TRUE(each.compared);
      EXPECT_EQ(each.first_later_stop, stops / 2);
      EXPECT_LT(each.chi2, 40.0) << seed;
      sum += each.chi2 / (runs * lidars);
    }
  }
  // Six where the planes are known exactly; they are not, and poses take up a part.
  EXPECT_GT(sum, 3.0);
  EXPECT_LT(sum, 9.0);
}

TEST(TimeHalves, TellHowFarALidarSlipped) {
  const SE3 slip{exp_so3(to_rad(0.3) * Vector3d::UnitZ()), Vector3d(0.01, -0.02, 0.0)};
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    const std::vector<TimeHalves> halves = Rig3(seed, slip).halves();
    EXPECT_GT(halves[2].chi2, 100.0);
    // The stops followed it by a third, as one of three LiDARs.
    EXPECT_NEAR(to_deg(halves[2].rotation_rad), 0.2, 0.05);
    EXPECT_NEAR(halves[2].translation_m, 2.0 / 3.0 * slip.t.norm(), 0.004);
  }
}

TEST(TimeHalves, AreNotComparedWhereALidarSawFewStops) {
  Rig3 rig(1, SE3{});
  for (PlaneFeature& feature : rig.features)
    std::erase_if(feature.observations, [](const PlaneObservation& o) { return o.lidar == 1 && o.stop >= 3; });
  const std::vector<TimeHalves> halves = rig.halves();
  EXPECT_TRUE(halves[0].compared);
  EXPECT_FALSE(halves[1].compared);
}

}  // namespace
}  // namespace rigcal
