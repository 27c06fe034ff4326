#include "core/quality/time_halves.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/quality/loose_rig.h"

namespace rigcal {
namespace {

constexpr int stops = 8;
constexpr int lidars = LooseRig::lidars;

// The last LiDAR slips by that from the fifth stop on.
LooseRig slipping(std::uint64_t seed, const SE3& slip) {
  Random random(seed);
  return {stops, 40, random, [&](int stop) { return stop < stops / 2 ? SE3{} : slip; }};
}

std::vector<TimeHalves> halves_of(const LooseRig& rig) {
  return compare_time_halves({rig.features, rig.state, rig.layout, rig.options});
}

TEST(TimeHalves, OfWhatStaysDifferByNoMoreThanTheirNoise) {
  double sum = 0.0;
  constexpr int runs = 40;
  for (std::uint64_t seed = 1; seed <= runs; ++seed) {
    const std::vector<TimeHalves> halves = halves_of(slipping(seed, SE3{}));
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
    const std::vector<TimeHalves> halves = halves_of(slipping(seed, slip));
    EXPECT_GT(halves[2].chi2, 100.0);
    // The stops followed it by a third, as one of three LiDARs.
    EXPECT_NEAR(to_deg(halves[2].rotation_rad), 0.2, 0.05);
    EXPECT_NEAR(halves[2].translation_m, 2.0 / 3.0 * slip.t.norm(), 0.004);
  }
}

TEST(TimeHalves, AreNotComparedWhereALidarSawFewStops) {
  LooseRig rig = slipping(1, SE3{});
  for (PlaneFeature& feature : rig.features)
    std::erase_if(feature.observations, [](const PlaneObservation& o) { return o.lidar == 1 && o.stop >= 3; });
  const std::vector<TimeHalves> halves = halves_of(rig);
  EXPECT_TRUE(halves[0].compared);
  EXPECT_FALSE(halves[1].compared);
}

}  // namespace
}  // namespace rigcal
