#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/board/board_sightings.h"
#include "tests/support/ring_scans.h"

namespace rigcal {
namespace {

BoardModel make_board() { return BoardModel({"checkerboard", {7, 4}, 0.1, {1.0, 0.7}, {0.0, 0.0}}); }

struct DenseScan {
  double sigma_m = 0.009;  ///< Of ranges, as real boards show.
  double dark_farther_m = 0.0;
  double range_offset_m = 0.0;
  double dark_reflectivity = 10.0;
  int shots = 60000;
};

// A cone of 19 degrees, filled evenly, onto a board 1.5 m before a wall. Beams are 0.28 by 0.03 degrees wide and answer
// from what most of their light meets.
std::vector<Point> scan(const SE3& T, const BoardModel& board, const DenseScan& options, Random& random) {
  std::vector<Point> out;
  const SE3 to_board = T.inverse();
  for (int k = 0; k < options.shots; ++k) {
    const double angle = to_rad(19.0) * std::sqrt(random.uniform());
    const double turn = 2.0 * pi * random.uniform();
    const auto meet = [&](double up, double side, double& range, int& colour) {
      const Vector3d ray =
          Vector3d(1.0, std::tan(angle) * std::cos(turn) + side, std::tan(angle) * std::sin(turn) + up).normalized();
      range = (T.t.norm() + 1.5) / ray.x();
      colour = 0;
      const double r = T.R.col(2).dot(T.t) / T.R.col(2).dot(ray);
      const Vector3d q = to_board * Vector3d(r * ray);
      if (std::abs(q.x()) > 0.5 * board.size().x() || std::abs(q.y()) > 0.5 * board.size().y()) return false;
      range = r;
      colour = board.colour_at(q.x(), q.y(), 0.0) == 1 ? 2 : 1;
      return true;
    };
    int on = 0;
    double range = 0.0;
    int colour = 0;
    for (const double up : {-0.0016, 0.0, 0.0016}) on += meet(up, 0.0, range, colour) ? 1 : 0;
    const bool hit = meet(0.0, 0.0, range, colour);
    if (hit != (on >= 2)) continue;
    range += options.sigma_m * random.normal() + (colour == 2 ? options.dark_farther_m : 0.0) + options.range_offset_m;
    const Vector3d ray = Vector3d(1.0, std::tan(angle) * std::cos(turn), std::tan(angle) * std::sin(turn)).normalized();
    Point& p = out.emplace_back();
    p.x = static_cast<float>(range * ray.x());
    p.y = static_cast<float>(range * ray.y());
    p.z = static_cast<float>(range * ray.z());
    const double reflectivity = colour == 2 ? options.dark_reflectivity : 60.0;
    p.reflectivity = static_cast<std::uint8_t>(std::clamp(reflectivity + 6.0 * random.normal(), 0.0, 255.0));
  }
  return out;
}

double nearest_turn(const CloudBoard& found, const SE3& T, const BoardModel& board) {
  double nearest = 1e9;
  for (const SE3& turn : board.plate_turns()) {
    nearest = std::min(nearest, board.corner_distance(found.T_lidar_board * turn, T));
  }
  return nearest;
}

TEST(DenseBoards, FindsThePlateByItsOutlineAlone) {
  Random random(1);
  const BoardModel board = make_board();
  for (int trial = 0; trial < 6; ++trial) {
    const SE3 T = plate_at(0.05 * (trial - 3), 2.6 + 0.3 * trial, 0.3 * trial, 0.3 * ((trial % 3) - 1));
    DenseScan plain;
    plain.dark_reflectivity = 60.0;
    const CloudBoards seen = find_dense_boards(scan(T, board, plain, random), board);
    ASSERT_EQ(seen.boards.size(), 1u) << trial << seen.why_none;
    EXPECT_FALSE(seen.boards[0].squares);
    EXPECT_LT(nearest_turn(seen.boards[0], T, board), 0.015) << trial;
    EXPECT_NEAR(seen.boards[0].plane_rms_m, 0.009, 0.003);
    // Twice this is the error of the plate's size, of which 10 mm are wanted.
    EXPECT_LT(seen.boards[0].growth_m.cwiseAbs().maxCoeff(), 0.005) << trial;
  }
}

TEST(DenseBoards, PlacesTheSquaresAndKnowsHowMuchFartherDarkOnesSeem) {
  Random random(2);
  const BoardModel board = make_board();
  for (const double farther : {-0.006, -0.002, 0.0, 0.002, 0.006}) {
    const SE3 T = plate_at(0.1, 3.2, 0.6, 0.25);
    DenseScan options;
    options.dark_farther_m = farther;
    const CloudBoards seen = find_dense_boards(scan(T, board, options, random), board);
    ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
    const CloudBoard& found = seen.boards[0];
    ASSERT_TRUE(found.squares);
    EXPECT_LT(nearest_turn(found, T, board), 0.004) << farther;
    EXPECT_NEAR(found.squares->dark_farther_m, farther, 0.001);
  }
}

// The plate's outline is fitted either way up; the squares lie beside its middle.
TEST(DenseBoards, PlacesSquaresBesideTheMiddleOfThePlateEitherWayUp) {
  Random random(7);
  for (const int rows : {4, 5}) {
    for (const double offset : {0.01, 0.05}) {
      const BoardModel board({"checkerboard", {7, rows}, 0.1, {1.0, 0.7}, {offset, 0.0}});
      for (const double turn : {0.6, 0.6 + pi}) {
        const SE3 T = plate_at(0.0, 3.2, turn, 0.25);
        const CloudBoards seen = find_dense_boards(scan(T, board, {}, random), board);
        ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
        ASSERT_TRUE(seen.boards[0].squares);
        const BoardSighting sighting = cloud_sighting(0, 0, seen.boards[0], board);
        double off = 1e9;
        for (const SE3& left : sighting.alternatives) {
          off = std::min(off, board.corner_distance(sighting.T_sensor_board * left, T));
        }
        EXPECT_LT(off, 0.004) << rows << offset << turn;
        EXPECT_EQ(sighting.alternatives.size(), rows == 4 ? 1u : 2u);
      }
    }
  }
}

TEST(DenseBoards, KnowsTheDistanceBySquaresWhereRangesAreOff) {
  Random random(6);
  const BoardModel board = make_board();
  for (const double offset : {-0.03, 0.03}) {
    const SE3 T = plate_at(-0.05, 3.4, 0.7, -0.2);
    DenseScan options;
    options.range_offset_m = offset;
    const CloudBoards seen = find_dense_boards(scan(T, board, options, random), board);
    ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
    ASSERT_TRUE(seen.boards[0].squares);
    EXPECT_NEAR(seen.boards[0].T_lidar_board.t.norm(), T.t.norm() + offset, 0.004);
    EXPECT_NEAR(seen.boards[0].squares->T_lidar_pattern.t.norm(), T.t.norm(), 0.006);
    EXPECT_LT(seen.boards[0].squares->scale_sigma, 0.003);
  }
}

TEST(DenseBoards, DoesNotTakeTheEndOfItsViewForAnEdge) {
  Random random(4);
  const BoardModel board = make_board();
  // A tenth of the plate is outside of the cone.
  const SE3 T = plate_at(0.19, 2.6, 0.1, 0.2);
  const CloudBoards seen = find_dense_boards(scan(T, board, {}, random), board);
  ASSERT_EQ(seen.boards.size(), 1u) << seen.why_none;
  EXPECT_LT(seen.boards[0].overlap, 0.97);
  EXPECT_LT(nearest_turn(seen.boards[0], T, board), 0.01);
}

TEST(DenseBoards, RefusesAPieceOfALargerSurface) {
  Random random(5);
  const BoardModel board = make_board();
  // A wall of which only a stretch of the board's size is dense enough to be followed.
  std::vector<Point> points;
  const auto add = [&](double half_y, double half_z, int count) {
    for (int k = 0; k < count; ++k) {
      Point& p = points.emplace_back();
      p.x = static_cast<float>(4.0 + 0.005 * random.normal());
      p.y = static_cast<float>(random.uniform(-half_y, half_y));
      p.z = static_cast<float>(random.uniform(-half_z, half_z));
    }
  };
  add(0.5, 0.35, 1300);
  EXPECT_EQ(find_dense_boards(points, board).boards.size(), 1u);
  add(1.5, 1.2, 3200);
  EXPECT_TRUE(find_dense_boards(points, board).boards.empty());
}

TEST(DenseBoards, FindsNothingOnABareWall) {
  Random random(3);
  const BoardModel board = make_board();
  SE3 far = plate_at(0.0, 2.0, 0.0, 0.0);
  far.t = {2.0, 3.0, 0.0};  // beside the field of view
  const CloudBoards seen = find_dense_boards(scan(far, board, {}, random), board);
  EXPECT_TRUE(seen.boards.empty());
  EXPECT_FALSE(seen.why_none.empty());
  EXPECT_TRUE(find_dense_boards({}, board).boards.empty());
}

}  // namespace
}  // namespace rigcal
