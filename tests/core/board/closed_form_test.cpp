#include "core/board/closed_form.h"

#include <gtest/gtest.h>

#include "core/board/board_model.h"
#include "tests/support/make_planes.h"
#include "tests/support/se3_matchers.h"

namespace rigcal {
namespace {

std::vector<BoardPair> make_pairs(int boards, const SE3& T_a_b, Random& random, bool parallel = false) {
  const BoardModel board({"checkerboard", {10, 8}, 0.07, {0.77, 0.63}, {0.0, 0.0}});
  std::vector<BoardPair> out;
  for (int k = 0; k < boards; ++k) {
    SE3 T = random_pose(random, 0.8, 1.0);
    if (parallel) T.R = Matrix3d::Identity();
    T.t.z() += 3.0;
    out.push_back({board_side(T, board.plate_corners()), board_side(T_a_b.inverse() * T, board.plate_corners())});
  }
  return out;
}

TEST(ClosedForm, IsExactWithoutNoise) {
  Random random(7);
  const SE3 T_a_b = random_pose(random, 1.0, 0.5);
  for (const int boards : {1, 2, 3, 12}) {
    const auto pairs = make_pairs(boards, T_a_b, random);
    const auto found = closed_form(pairs);
    ASSERT_TRUE(found);
    EXPECT_LT(rotation_distance(found->T_a_b.R, T_a_b.R), 1e-9);
    EXPECT_LT((found->T_a_b.t - T_a_b.t).norm(), 1e-9);
    EXPECT_EQ(found->by_planes.has_value(), boards >= 3);
    if (!found->by_planes) continue;
    EXPECT_LT(rotation_distance(found->by_planes->R, T_a_b.R), 1e-9);
    EXPECT_LT((found->by_planes->t - T_a_b.t).norm(), 1e-8);
  }
}

TEST(ClosedForm, LeavesToTheCornersWhatParallelBoardsDoNotTell) {
  Random random(8);
  const SE3 T_a_b = random_pose(random, 1.0, 0.5);
  const auto pairs = make_pairs(6, T_a_b, random, true);
  EXPECT_FALSE(rotation_by_normals(pairs));
  EXPECT_FALSE(translation_by_planes(pairs, T_a_b.R));
  const auto found = closed_form(pairs);
  ASSERT_TRUE(found);
  EXPECT_LT(rotation_distance(found->T_a_b.R, T_a_b.R), 1e-9);
}

TEST(ClosedForm, HasNothingToSayWithoutABoard) { EXPECT_FALSE(closed_form({})); }

}  // namespace
}  // namespace rigcal
