#include "core/board/board_model.h"

#include <gtest/gtest.h>

namespace rigcal {
namespace {

BoardModel make_board(int columns, int rows, Eigen::Vector2d size = {0.0, 0.0}, Eigen::Vector2d offset = {0.0, 0.0}) {
  BoardSettings settings;
  settings.inner_corners = {columns, rows};
  settings.square = 0.1;
  settings.size = {size.x(), size.y()};
  settings.offset = {offset.x(), offset.y()};
  return BoardModel(settings);
}

TEST(BoardModel, EndsWithItsSquaresWhereNoSizeIsGiven) {
  const BoardModel board = make_board(7, 5);
  EXPECT_NEAR(board.size().x(), 0.8, 1e-12);
  EXPECT_NEAR(board.size().y(), 0.6, 1e-12);
  EXPECT_LT((board.corner(0) - Vector3d(-0.3, -0.2, 0.0)).norm(), 1e-12);
  EXPECT_LT((board.corner(34) - Vector3d(0.3, 0.2, 0.0)).norm(), 1e-12);
}

TEST(BoardModel, KnowsCornersByPlace) {
  const BoardModel board = make_board(7, 5, {1.0, 0.8}, {0.02, -0.03});
  for (int id = 0; id < board.corner_count(); ++id) {
    EXPECT_EQ(board.id_at(board.corner(id) + Vector3d(0.01, -0.01, 0.0)), id);
  }
  EXPECT_EQ(board.id_at(board.lattice(-1, 0)), -1);
  EXPECT_EQ(board.id_at(board.lattice(0.5, 0)), -1);
}

// Turns after which all squares look as before, and only those.
TEST(BoardModel, LooksTheSameAfterItsTurns) {
  const std::vector<std::pair<std::pair<int, int>, std::size_t>> cases{
      {{7, 5}, 2}, {{9, 6}, 1}, {{10, 8}, 2}, {{4, 4}, 4}, {{5, 5}, 2}};
  for (const auto& [corners, turns] : cases) {
    const BoardModel board = make_board(corners.first, corners.second, {2.0, 2.0}, {0.05, 0.02});
    const auto same = board.pattern_turns();
    EXPECT_EQ(same.size(), turns) << corners.first << " by " << corners.second;
    for (const SE3& turn : same) {
      for (double x = -0.5; x < 0.55; x += 0.1) {
        for (double y = -0.4; y < 0.45; y += 0.1) {
          const Vector3d p = turn * Vector3d(x + 0.013, y + 0.017, 0.0);
          EXPECT_EQ(board.colour_at(x + 0.013, y + 0.017, 0.0), board.colour_at(p.x(), p.y(), 0.0));
        }
      }
    }
  }
}

TEST(BoardModel, TurnsItsPlateOntoItself) {
  EXPECT_EQ(make_board(7, 5, {0.85, 0.61}).plate_turns().size(), 2u);
  const BoardModel square = make_board(7, 5, {0.85, 0.85});
  EXPECT_EQ(square.plate_turns().size(), 4u);
  for (const SE3& turn : square.plate_turns()) {
    double nearest = 1e9;
    for (const Vector3d& corner : square.plate_corners()) {
      nearest = std::min(nearest, (corner - turn * square.plate_corners()[0]).norm());
    }
    EXPECT_LT(nearest, 1e-12);
  }
}

}  // namespace
}  // namespace rigcal
