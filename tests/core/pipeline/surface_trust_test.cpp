#include "core/pipeline/surface_trust.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

const RigState two_stops{{SE3{}, SE3{}}, {SE3{}}};

// Forty leaves of 1 m, seen from two stops, by one a bit above the plane between and by the other as far below.
PlaneMap leaves(double off_m) {
  PlaneMap map;
  for (int i = 0; i < 40; ++i) {
    PlaneFeature& leaf = map.features.emplace_back();
    leaf.size_m = 1.0;
    for (int stop = 0; stop < 2; ++stop) {
      PlaneObservation& o = leaf.observations.emplace_back();
      o.stop = stop;
      o.N = 100.0;
      o.mean = {0.1 * i, 0.0, stop == 0 ? off_m : -off_m};
      o.scatter = o.N / 12.0 * Vector3d(1.0, 1.0, 0.0).asDiagonal().toDenseMatrix();
      o.offset_variance = 1e-8;
    }
  }
  return map;
}

RefinePass tight_pass(const SurfaceTrust& trust) {
  RefinePass pass = standard_passes(1).back();
  trust.set_gates(pass);
  return pass;
}

TEST(SurfaceTrust, LeavesTheFirstTightPassItsFloor) {
  const RefinePass pass = tight_pass(SurfaceTrust{});
  EXPECT_TRUE(pass.trust_noise);
  EXPECT_EQ(pass.map.offset_floor_m, PlaneMapOptions{}.offset_floor_m);
  EXPECT_EQ(pass.map.gate_slack_m, 0.0);
}

TEST(SurfaceTrust, TakesSurfacesToBeAsFlatAsTheyShowThemselvesButNotFlatterThanAnyIs) {
  SurfaceTrust trust;
  trust.look_at_gates(leaves(0.0005), two_stops, 0.0);
  const double floor_m = tight_pass(trust).map.offset_floor_m;
  EXPECT_GT(floor_m, 0.0005);
  EXPECT_LT(floor_m, PlaneMapOptions{}.offset_floor_m + 1e-12);
  trust.look_at_gates(leaves(0.0), two_stops, 0.0);
  EXPECT_EQ(tight_pass(trust).map.offset_floor_m, 0.0003);
  EXPECT_EQ(trust.unevenness_m(), 0.0);
}

TEST(SurfaceTrust, OpensGatesWhereSurfacesAreUnevenBeforeGatesSelect) {
  SurfaceTrust trust;
  trust.look_loosely(leaves(0.005), two_stops, 0.0);
  EXPECT_GT(trust.unevenness_m(), 0.005);
  trust.look_at_gates(leaves(0.0001), two_stops, 0.0);  // What gates let through agrees.
  const RefinePass pass = tight_pass(trust);
  EXPECT_EQ(pass.map.gate_slack_m, trust.unevenness_m());
  EXPECT_EQ(pass.map.offset_floor_m, trust.unevenness_m());
  EXPECT_GT(pass.map.max_chi2, PlaneMapOptions{}.max_chi2);
}

TEST(SurfaceTrust, IsNotShownByDistancesThatErrorsOfRangesMayHaveMade) {
  SurfaceTrust trust;
  trust.look_at_gates(leaves(0.0), two_stops, 0.0);
  trust.distrust_noise();
  const RefinePass pass = tight_pass(trust);
  EXPECT_FALSE(pass.trust_noise);
  EXPECT_EQ(pass.map.offset_floor_m, PlaneMapOptions{}.offset_floor_m);
}

}  // namespace
}  // namespace rigcal
