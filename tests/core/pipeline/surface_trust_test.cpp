#include "core/pipeline/surface_trust.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/leaves_from_two_stops.h"

namespace rigcal {
namespace {

const RigState two_stops = state_of_two_stops();

PlaneMap leaves(double off_m) {
  PlaneMap map;
  add_leaves(1.0, off_m, 1e-8, map);
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
  trust.look_at_gates(leaves(0.0003), two_stops, 0.0);
  // Squares over half a freedom, by the median of a squared normal variable, and the noise's tenth of a millimetre.
  EXPECT_NEAR(tight_pass(trust).map.offset_floor_m, std::sqrt(2.0 * 9e-8 / 0.455 - 1e-8), 1e-5);
  trust.look_at_gates(leaves(0.001), two_stops, 0.0);
  EXPECT_EQ(tight_pass(trust).map.offset_floor_m, PlaneMapOptions{}.offset_floor_m) << "nor less flat than usual";
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
