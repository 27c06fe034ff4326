#include "core/camera/edge_solver.h"

#include <gtest/gtest.h>

#include "tests/core/camera/box_room.h"
#include "tests/core/camera/joint_solve.h"

namespace rigcal {
namespace {

// The linearisation and the elimination of the lines' shifts, against a solver that many have used.
TEST(EdgeSolver, EndsWhereAJointSolveOfAllUnknownsDoes) {
  SilentReporter reporter;
  const BoxRoom room;
  const CameraTask task = room.task(BoxRoom::truth());
  std::vector<EdgeView> views = make_edge_views(room.scene, task);
  ASSERT_EQ(views.size(), task.views.size());
  const CameraState start{BoxRoom::spoiled(to_rad(0.2), 0.01, 9)};
  find_visible(room.scene, task.intrinsics, start, VisibleOptions{}, views);
  EdgePriors priors;
  priors.T_base_camera = start.T_base_camera;
  const std::vector<SolveLevel> levels = standard_levels();
  const EdgeSolution annealed =
      solve_edges(room.scene, task.intrinsics, start, priors, levels, views, RunContext{reporter});
  EXPECT_TRUE(annealed.converged);
  const JointSolution joint =
      solve_jointly(room.scene, task.intrinsics, annealed.state, priors, levels.back().match, views);
  EXPECT_TRUE(joint.converged);
  const Vector6d apart = (annealed.state.T_base_camera.inverse() * joint.state.T_base_camera).log();
  EXPECT_LT(apart.head<3>().norm(), to_rad(1e-3));
  EXPECT_LT(apart.tail<3>().norm(), 1e-4);
}

}  // namespace
}  // namespace rigcal
