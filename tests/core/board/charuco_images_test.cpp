#include "core/board/charuco_images.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/board/markers.h"
#include "core/rig/marker_dictionaries.h"
#include "tests/support/board_pictures.h"

namespace rigcal {
namespace {

CameraModel test_camera() {
  return CameraModel({DistortionModel::radtan, 960, 720, 630.0, 630.0, 479.5, 359.5, {-0.15, 0.03, 0.0, 0.0, 0.0}});
}

BoardModel make_board(int columns, int rows, const char* dictionary = "DICT_5X5_100") {
  BoardSettings settings{"charuco", {columns, rows}, 0.1, {0.1 * (columns + 2), 0.1 * (rows + 2)}, {0.0, 0.0}};
  settings.dictionary = dictionary;
  settings.marker = 0.07;
  return BoardModel(settings);
}

SE3 pose(double rx, double ry, double rz, double x, double y, double z) { return {exp_so3({rx, ry, rz}), {x, y, z}}; }

class Charuco : public testing::Test {
 protected:
  void SetUp() override {
    if (!knows_markers()) GTEST_SKIP() << "built without OpenCV's aruco module";
  }
};

TEST_F(Charuco, KnowsWhichCornerIsWhichWhicheverWayTheBoardIsTurned) {
  for (const BoardModel& board : {make_board(7, 4), make_board(8, 6, "DICT_4X4_50")}) {
    for (const double turn : {0.1, 1.7, 3.1, -1.3}) {
      const SE3 T = pose(0.3, -0.2, turn, 0.1, -0.05, 1.5);
      const ImageBoards seen = find_image_boards(board_picture(test_camera(), {T}, board), board);
      ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
      EXPECT_TRUE(seen.boards[0].whole) << turn << ": " << seen.boards[0].ids.size();
      EXPECT_EQ(seen.boards[0].alternatives.size(), 1u);
      const auto found = find_image_pose(seen.boards[0], board, test_camera());
      ASSERT_TRUE(found);
      EXPECT_LT(found->rms_px, 0.25);
      EXPECT_LT(board.corner_distance(found->T_camera_board, T), 0.006) << turn;
    }
  }
}

TEST_F(Charuco, UsesPartsThatTheImageCutsOrSomethingHides) {
  const BoardModel board = make_board(7, 4);
  const SE3 cut = pose(0.1, -0.2, 0.05, 0.85, 0.0, 1.3);
  GreyImage image = board_picture(test_camera(), {cut}, board);
  ImageBoards seen = find_charuco_board(image, board);
  ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
  EXPECT_FALSE(seen.boards[0].whole);
  EXPECT_GE(seen.boards[0].ids.size(), 8u);
  auto found = find_image_pose(seen.boards[0], board, test_camera());
  ASSERT_TRUE(found);
  EXPECT_LT(board.corner_distance(found->T_camera_board, cut), 0.03);
  // A hand before its middle.
  const SE3 T = pose(-0.2, 0.25, -0.4, 0.0, 0.0, 1.4);
  image = board_picture(test_camera(), {T}, board);
  for (int y = 320; y < 400; ++y) {
    for (int x = 430; x < 530; ++x) image.values[static_cast<std::size_t>(y * image.width + x)] = 90.0F;
  }
  seen = find_charuco_board(image, board);
  ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
  EXPECT_FALSE(seen.boards[0].whole);
  EXPECT_GE(seen.boards[0].ids.size(), 12u);
  found = find_image_pose(seen.boards[0], board, test_camera());
  ASSERT_TRUE(found);
  EXPECT_LT(found->rms_px, 0.4);
  EXPECT_LT(board.corner_distance(found->T_camera_board, T), 0.01);
}

// With an even number of rows of squares old boards begin with a bright square. Where the colours tell which end is up,
// our frame begins at the dark one.
TEST_F(Charuco, KnowsBoardsOfOldOpenCv) {
  for (const int columns : {7, 6}) {
    const BoardModel board = make_board(columns, 5);
    const SE3 T = pose(0.2, 0.2, 0.3, 0.0, 0.05, 1.5);
    const ImageBoards seen = find_charuco_board(board_picture(test_camera(), {T}, board, true), board);
    ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
    EXPECT_TRUE(seen.boards[0].whole);
    const auto found = find_image_pose(seen.boards[0], board, test_camera());
    ASSERT_TRUE(found);
    const SE3 expected = columns == 7 ? T : T * SE3{exp_so3({0.0, 0.0, pi}), Vector3d::Zero()};
    EXPECT_LT(board.corner_distance(found->T_camera_board, expected), 0.006) << columns;
  }
}

TEST_F(Charuco, SaysThatThereIsNone) {
  const BoardModel board = make_board(7, 4);
  const ImageBoards none = find_charuco_board(board_picture(test_camera(), {}, board), board);
  EXPECT_TRUE(none.boards.empty());
  EXPECT_EQ(none.why_none, "no marker of the board's dictionary in it");
  const ImageBoards strange = find_charuco_board(
      board_picture(test_camera(), {pose(0.0, 0.1, 0.0, 0.0, 0.0, 1.5)}, board), make_board(7, 4, "DICT_6X6_50"));
  EXPECT_TRUE(strange.boards.empty());
  const GreyImage tiny{3, 2, std::vector<float>(6, 10.0F)};
  EXPECT_TRUE(find_charuco_board(tiny, board).boards.empty());
}

TEST_F(Charuco, KnowsWhatMarkersLookLike) {
  const auto cells = marker_cells(marker_dictionary("DICT_5X5_100"), 17);
  ASSERT_TRUE(cells);
  EXPECT_EQ(cells->side, 7);
  for (std::size_t k = 0; k < 7; ++k) EXPECT_TRUE(cells->dark[k] && cells->dark[7 * k] && cells->dark[42 + k]);
  EXPECT_GT(std::count(cells->dark.begin(), cells->dark.end(), 0), 0);
  EXPECT_FALSE(marker_cells(marker_dictionary("DICT_5X5_100"), 100));
  EXPECT_FALSE(marker_cells(-1, 0));
  EXPECT_FALSE(marker_cells(21, 0));
}

}  // namespace
}  // namespace rigcal
