#include "core/planes/damped_passes.h"

#include <gtest/gtest.h>

#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

// Two stops and two LiDARs, the second by this far out of its place.
RigState rig_off_by(double off) {
  const Vector6d xi = (Vector6d() << 1e-3, -2e-3, 0.5e-3, 0.02, 0.01, -0.03).finished();
  const SE3 T(exp_so3(Vector3d(0.3, 1.0, -0.4)), Vector3d(0.5, -0.2, 0.1));
  RigState state;
  state.T_base_sensor = {SE3{}, T * SE3::exp(off * xi)};
  state.T_G_base = {SE3{}, T.inverse() * SE3::exp(-0.5 * off * xi)};
  return state;
}

void expect_alike(const RigState& a, const RigState& b) {
  EXPECT_THAT(a.T_base_sensor[1], SE3Near(b.T_base_sensor[1], 1e-5, 1e-3));
  EXPECT_THAT(a.T_G_base[1], SE3Near(b.T_G_base[1], 1e-5, 1e-3));
}

TEST(DampedPasses, EndHalfwayBetweenTwoStatesThatPassesGoToAndFroBetween) {
  DampedPasses damped;
  RigState state = rig_off_by(-1.0);
  damped.take(rig_off_by(1.0), state);
  expect_alike(state, rig_off_by(-1.0));
  state = rig_off_by(1.0);
  damped.take(rig_off_by(-1.0), state);
  expect_alike(state, rig_off_by(0.0));
}

TEST(DampedPasses, LeaveAloneWhatGoesOnOneWayAndWhatGoesALittleBack) {
  DampedPasses damped;
  double off = 1.0;
  for (const double next : {0.4, 0.1, 0.02, 0.0, -0.01}) {
    RigState state = rig_off_by(next);
    damped.take(rig_off_by(off), state);
    expect_alike(state, rig_off_by(next));
    off = next;
  }
  RigState turned = rig_off_by(-0.01);
  turned.T_base_sensor[1].t += 0.01 * Vector3d(0.01, -0.02, 0.0);
  const RigState across = turned;
  damped.take(rig_off_by(-0.01), turned);
  expect_alike(turned, across);
}

TEST(DampedPasses, LeaveARigWithoutMovesWhereItIs) {
  DampedPasses damped;
  for (int pass = 0; pass < 3; ++pass) {
    RigState state = rig_off_by(0.2);
    damped.take(rig_off_by(0.2), state);
    expect_alike(state, rig_off_by(0.2));
  }
}

}  // namespace
}  // namespace rigcal
