#include "core/camera/end_solve.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include "core/geometry/matrix6.h"
#include "tests/core/camera/box_room.h"

namespace rigcal {
namespace {

class EndSolveTest : public testing::Test {
 protected:
  EndSolveTest() : task_(images()) { priors_.T_base_camera = BoxRoom::truth(); }

  static const BoxRoom& room() {
    static const BoxRoom room;
    return room;
  }
  static const CameraTask& images() {
    static const CameraTask task = room().task(BoxRoom::truth());
    return task;
  }
  [[nodiscard]] CameraEnd end(bool refine_intrinsics = false) const {
    SilentReporter reporter;
    std::vector<EdgeView> views = make_edge_views(room().scene, task_);
    const CameraState start{BoxRoom::spoiled(to_rad(0.3), 0.01, 2)};
    return solve_end(room().scene, task_, refine_intrinsics, priors_, start, views, RunContext{reporter});
  }
  void spoil_focal_length() {
    task_.intrinsics.fx *= 1.01;
    task_.intrinsics.fy *= 1.01;
  }

  CameraTask task_;
  EdgePriors priors_;
};

TEST_F(EndSolveTest, HoldsToIntrinsicsThatFitUnlessOthersAreAskedFor) {
  const CameraEnd held = end();
  EXPECT_TRUE(held.solution.converged);
  EXPECT_EQ(held.priors.focal_scale, priors_.focal_scale);
  EXPECT_EQ(held.priors.k1, priors_.k1);
  EXPECT_FALSE(is_off(held.focal_scale));
  EXPECT_GT(held.focal_scale.sigma, 0.0);
  EXPECT_GT(held.k1_change.sigma, 0.0);
  const CameraEnd asked = end(true);
  EXPECT_EQ(asked.priors.k1, with_free_intrinsics(priors_).k1);
  EXPECT_EQ(asked.k1_change.value, asked.solution.state.k1_change);
  EXPECT_LT(asked.solution.information(7, 7), held.solution.information(7, 7));
}

// A false match bends the lens; where edges end with another start, the intrinsics of the rig file are believed again.
TEST_F(EndSolveTest, FreesIntrinsicsForTheOneEndThatAsksForOthers) {
  const CameraEnd before = end();
  spoil_focal_length();
  const CameraEnd bent = end();
  EXPECT_TRUE(is_off(bent.focal_scale));
  EXPECT_EQ(bent.priors.focal_scale, with_free_intrinsics(priors_).focal_scale);
  EXPECT_NEAR(bent.solution.state.focal_scale, -0.01, 0.003);
  task_.intrinsics = images().intrinsics;
  const CameraEnd after = end();
  EXPECT_EQ(after.priors.focal_scale, priors_.focal_scale);
  EXPECT_EQ(after.solution.information, before.solution.information);
  EXPECT_EQ(after.solution.state.T_base_camera.t, before.solution.state.T_base_camera.t);
}

TEST_F(EndSolveTest, FreesAPrincipalPointThatIsOffAndNoOther) {
  const CameraEnd before = end();
  EXPECT_EQ(before.priors.principal_px, 0.0);
  EXPECT_FALSE(is_off_px(before.cx_change_px));
  EXPECT_FALSE(is_off_px(before.cy_change_px));
  EXPECT_GT(before.cy_change_px.sigma, 0.0);
  EXPECT_LT(before.solution.state.principal_change_px.norm(), 1e-3);
  EXPECT_LT(end(true).solution.state.principal_change_px.norm(), 1e-3) << "asked for, but nothing contradicts it";
  task_.intrinsics.cx += 8.0;
  const CameraEnd off = end();
  EXPECT_TRUE(off.solution.converged);
  EXPECT_TRUE(is_off_px(off.cx_change_px));
  EXPECT_NEAR(off.cx_change_px.value, -8.0, 4.0 * off.cx_change_px.sigma);
  EXPECT_EQ(off.solution.state.principal_change_px.x(), off.cx_change_px.value);
  const SE3 apart = off.solution.state.T_base_camera.inverse() * before.solution.state.T_base_camera;
  const CameraMatrix covariance = off.solution.information.inverse();
  EXPECT_LT(apart.log().dot(solve_symmetric6(covariance.topLeftCorner<6, 6>(), apart.log())), 22.5);
}

TEST_F(EndSolveTest, BelievesTheRigFileRatherThanThreeStops) {
  spoil_focal_length();
  task_.views.resize(least_stops_for_intrinsics - 1);
  const CameraEnd few = end();
  EXPECT_EQ(few.priors.focal_scale, priors_.focal_scale);
  EXPECT_EQ(few.focal_scale.sigma, 0.0);
  EXPECT_EQ(few.k1_change.sigma, 0.0);
  EXPECT_EQ(few.radial_trend.sigma, 0.0);
  EXPECT_GT(end(true).focal_scale.sigma, 0.0) << "who asks gets to see them";
}

}  // namespace
}  // namespace rigcal
