#include "core/start/axis_search.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/start/thrown_rig.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

double between_deg(const Vector3d& a, const Vector3d& b) { return to_deg(std::acos(std::min(1.0, a.dot(b)))); }

AxisTurn some_turn() {
  AxisTurn turn;
  turn.axis = Vector3d(0.3, -0.8, 0.2).normalized();
  turn.foot = Vector3d(0.4, 0.1, -0.5);
  turn.foot -= turn.foot.dot(turn.axis) * turn.axis;
  // A step of more than half a turn cannot be told from one the other way; these are less.
  turn.angle = {0.0, 0.5, 2.0, 2.4, 3.9, 5.0, 4.2};
  return turn;
}

TEST(TurnOfPoses, FindsTheAxisThatPosesTurnAbout) {
  const AxisTurn turn = some_turn();
  std::vector<SE3> poses;
  for (int j = 0; j < 7; ++j) poses.push_back(turn.pose(j));
  const auto found = turn_of_poses(poses, std::vector<char>(7, 1));
  ASSERT_TRUE(found);
  EXPECT_LT(between_deg(found->turn.axis, turn.axis), 1e-4);
  EXPECT_LT((found->turn.foot - turn.foot).norm(), 1e-6);
  EXPECT_LT(found->off_m, 1e-6);
  for (std::size_t j = 0; j < 7; ++j) EXPECT_NEAR(found->turn.angle[j], turn.angle[j], 1e-9);
}

TEST(TurnOfPoses, TakesOnlyKnownStopsAndCountsFromTheFirstOfThem) {
  const AxisTurn turn = some_turn();
  std::vector<SE3> poses;
  for (int j = 0; j < 7; ++j) poses.push_back(turn.pose(j));
  poses[0] = SE3{Matrix3d::Identity(), Vector3d(5.0, 0.0, 0.0)};
  poses[3] = poses[0];
  const auto found = turn_of_poses(poses, {0, 1, 1, 0, 1, 1, 1});
  ASSERT_TRUE(found);
  EXPECT_LT((found->turn.foot - turn.foot).norm(), 1e-6);
  EXPECT_NEAR(found->turn.angle[1], 0.0, 1e-9);
  EXPECT_NEAR(found->turn.angle[5], 4.5, 1e-9);
  EXPECT_THAT(poses[1] * found->turn.pose(6), SE3Near(poses[6], 1e-4, 1e-3));
}

TEST(TurnOfPoses, SaysHowFarTheRigWandered) {
  const AxisTurn turn = some_turn();
  std::vector<SE3> poses;
  for (int j = 0; j < 7; ++j) {
    poses.push_back(turn.pose(j));
    poses.back().t += 0.1 * std::sin(2.0 * j) * Vector3d::UnitX();
  }
  const auto found = turn_of_poses(poses, std::vector<char>(7, 1));
  ASSERT_TRUE(found);
  EXPECT_GT(found->off_m, 0.03);
  EXPECT_LT(found->off_m, 0.15);
}

TEST(TurnOfPoses, FindsNoneWhereNothingTurned) {
  EXPECT_FALSE(turn_of_poses({SE3{}, SE3{Matrix3d::Identity(), Vector3d::UnitX()}}, {1, 1}));
  EXPECT_FALSE(turn_of_poses({SE3{}, SE3{}}, {1, 0}));
}

TEST(FindOwnTurns, FindsTheAxisOfEachLidarFromWhatItSawAlone) {
  const ThrownRig rig("courtyard", 3, 14);
  const auto turn = turn_of_poses(rig.truth.T_G_base, std::vector<char>(14, 1));
  ASSERT_TRUE(turn);
  for (std::size_t i = 0; i < 4; ++i) {
    const auto found = find_own_turns(rig.patches_of(static_cast<int>(i)), turn->turn.angle, {});
    ASSERT_FALSE(found.empty()) << i;
    EXPECT_LT(between_deg(found[0].turn.axis, rig.axis_of(i)), 5.0) << i;
    EXPECT_GT(found[0].score, 0.25) << i;
  }
}

TEST(FindOwnTurns, TakesAKnownAxisAndFindsTheRest) {
  const ThrownRig rig("courtyard", 3, 14);
  const auto turn = turn_of_poses(rig.truth.T_G_base, std::vector<char>(14, 1));
  AxisSearchOptions options;
  options.axis = rig.axis_of(0);
  const auto found = find_own_turns(rig.patches_of(0), turn->turn.angle, options);
  ASSERT_EQ(found.size(), 1U);
  EXPECT_LT((found[0].turn.foot - turn->turn.foot).norm(), 0.05);
}

TEST(FindOwnTurns, HasNothingToSayOfOnePatch) {
  const ThrownRig rig("courtyard", 3, 3);
  EXPECT_TRUE(find_own_turns({rig.surfels[0]}, {0.0, 2.0, 4.0}, {}).empty());
  EXPECT_TRUE(find_own_turns({}, {0.0}, {}).empty());
}

}  // namespace
}  // namespace rigcal
