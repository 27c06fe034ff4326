#include "core/board/board_images.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/board_pictures.h"

namespace rigcal {
namespace {

CameraModel test_camera() {
  return CameraModel({DistortionModel::radtan, 640, 480, 420.0, 420.0, 319.5, 239.5, {-0.15, 0.03, 0.0, 0.0, 0.0}});
}

CameraModel fisheye_camera() {
  return CameraModel({DistortionModel::equidistant, 640, 480, 300.0, 300.0, 319.5, 239.5, {0.01, -0.005, 0.0, 0.0}});
}

BoardModel make_board(int columns, int rows) {
  const double width = 0.1 * (columns + 2);
  const double height = 0.1 * (rows + 2);
  return BoardModel({"checkerboard", {columns, rows}, 0.1, {width, height}, {0.0, 0.0}});
}

SE3 pose(double rx, double ry, double rz, double x, double y, double z) { return {exp_so3({rx, ry, rz}), {x, y, z}}; }

TEST(ImageBoards, PlacesWholeBoardsToAHundredthOfASquare) {
  const BoardModel board = make_board(7, 4);  // odd and even: the colours tell which end is up
  for (const CameraModel& camera : {test_camera(), fisheye_camera()}) {
    for (const double turn : {0.1, -2.0}) {
      const SE3 T = pose(0.3, -0.2, turn, 0.1, -0.05, 1.6);
      const ImageBoards seen = find_image_boards(board_picture(camera, {T}, board), board);
      ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
      EXPECT_TRUE(seen.boards[0].whole);
      EXPECT_EQ(seen.boards[0].alternatives.size(), 1u);
      const auto found = find_image_pose(seen.boards[0], board, camera);
      ASSERT_TRUE(found);
      EXPECT_LT(found->rms_px, 0.2);
      EXPECT_LT(board.corner_distance(found->T_camera_board, T), 0.01) << turn;
    }
  }
}

TEST(ImageBoards, LeaveOpenWhichEndIsUpWhereTheColoursDoNotTell) {
  const BoardModel board = make_board(6, 4);
  const CameraModel camera = test_camera();
  const SE3 T = pose(0.2, 0.3, 2.5, 0.0, 0.1, 1.5);
  const ImageBoards seen = find_image_boards(board_picture(camera, {T}, board), board);
  ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
  ASSERT_EQ(seen.boards[0].alternatives.size(), 2u);
  const auto found = find_image_pose(seen.boards[0], board, camera);
  ASSERT_TRUE(found);
  double nearest = 1e9;
  for (const SE3& turn : seen.boards[0].alternatives) {
    nearest = std::min(nearest, board.corner_distance(found->T_camera_board * turn, T));
  }
  EXPECT_LT(nearest, 0.01);
}

TEST(ImageBoards, FindsTwo) {
  const BoardModel board = make_board(6, 4);
  const std::vector<SE3> two{pose(0.1, 0.2, 0.1, -0.5, 0.0, 1.8), pose(-0.2, -0.3, 0.2, 0.55, 0.05, 1.9)};
  EXPECT_EQ(find_image_boards(board_picture(test_camera(), two, board), board).boards.size(), 2u);
}

TEST(ImageBoards, FindsABoardInTheDarkBesideALamp) {
  const BoardModel board = make_board(7, 4);
  const CameraModel camera = test_camera();
  const SE3 T = pose(0.2, -0.2, 0.3, 0.1, 0.0, 1.5);
  GreyImage image = board_picture(camera, {T}, board);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      float& value = image.values[static_cast<std::size_t>(y * image.width + x)];
      // By whole grey values, as a camera gives them; the lamp is in a corner.
      value = x < 60 && y < 60 ? 255.0F : std::round(0.04F * value);
    }
  }
  const ImageBoards seen = find_image_boards(image, board);
  ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
  const auto found = find_image_pose(seen.boards[0], board, camera);
  ASSERT_TRUE(found);
  EXPECT_LT(board.corner_distance(found->T_camera_board, T), 0.02);
}

TEST(ImageBoards, UsesThePartOfABoardThatTheImageCuts) {
  const BoardModel board = make_board(7, 4);
  const CameraModel camera = test_camera();
  const SE3 T = pose(0.1, -0.2, 0.05, 0.95, 0.0, 1.3);
  const ImageBoards seen = find_image_boards(board_picture(camera, {T}, board), board);
  EXPECT_NE(seen.why_none.find("cut by the image border"), std::string::npos) << seen.why_none;
  ASSERT_EQ(seen.boards.size(), 1u);
  const ImageBoard& part = seen.boards[0];
  EXPECT_FALSE(part.whole);
  EXPECT_LT(part.ids.size(), 28u);
  EXPECT_GE(part.ids.size(), 9u);
  const auto found = find_image_pose(part, board, camera);
  ASSERT_TRUE(found);
  double nearest = 1e9;
  for (const SE3& place : part.alternatives) {
    nearest = std::min(nearest, board.corner_distance(found->T_camera_board * place, T));
  }
  EXPECT_LT(nearest, 0.03) << part.alternatives.size() << " places";
}

// Its rows may come out along the board's columns, and the square at its first corner may be bright.
TEST(ImageBoards, APartIsPlacedHoweverTheBoardIsTurned) {
  const CameraModel camera = test_camera();
  int parts = 0;
  for (const auto& [columns, rows] : {std::pair{7, 5}, std::pair{7, 4}}) {
    const BoardModel board = make_board(columns, rows);
    for (int quarters = 0; quarters < 4; ++quarters) {
      const SE3 T = pose(0.1, -0.2, 0.05 + 0.5 * pi * quarters, 0.9, 0.0, 1.3);
      const ImageBoards seen = find_image_boards(board_picture(camera, {T}, board), board);
      if (seen.boards.size() != 1 || seen.boards[0].whole) continue;
      ++parts;
      const auto found = find_image_pose(seen.boards[0], board, camera);
      ASSERT_TRUE(found);
      double nearest = 1e9;
      for (const SE3& place : seen.boards[0].alternatives) {
        nearest = std::min(nearest, board.corner_distance(found->T_camera_board * place, T));
        for (const int id : seen.boards[0].ids) ASSERT_GE(board.id_at(place.inverse() * board.corner(id)), 0);
      }
      EXPECT_LT(nearest, 0.03) << columns << " by " << rows << ", turned by " << 90 * quarters << " degrees";
    }
  }
  EXPECT_GE(parts, 6);
}

TEST(ImageBoards, SaysSoWhereThereIsNone) {
  const ImageBoards seen = find_image_boards(board_picture(test_camera(), {}, make_board(7, 4)), make_board(7, 4));
  EXPECT_TRUE(seen.boards.empty());
  EXPECT_EQ(seen.why_none, "no checkerboard of 7 by 4 inner corners in it");
  EXPECT_TRUE(find_image_boards({8, 8, std::vector<float>(64, 0.0F)}, make_board(7, 4)).boards.empty());
}

TEST(ImagePose, WantsFourCorners) {
  ImageBoard few;
  few.ids = {0, 1, 2};
  few.pixels = {{100.0, 100.0}, {150.0, 100.0}, {200.0, 100.0}};
  EXPECT_FALSE(find_image_pose(few, make_board(7, 4), test_camera()));
}

}  // namespace
}  // namespace rigcal
