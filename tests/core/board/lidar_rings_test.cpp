#include "core/board/lidar_rings.h"

#include <gtest/gtest.h>

#include "core/base/random.h"
#include "core/board/board_clouds.h"
#include "tests/support/ring_scans.h"

namespace rigcal {
namespace {

BoardModel make_board() { return BoardModel({"checkerboard", {7, 5}, 0.095, {0.85, 0.61}, {0.0, 0.0}}); }

TEST(LidarRings, AreToldByTheirElevation) {
  Random random(1);
  std::vector<Point> points = ring_scan({}, {1.0, 1.0}, 0.01, random);
  std::swap(points[5], points[20000]);
  const auto rings = split_rings(points, false, 0.4);
  ASSERT_EQ(rings.size(), 16u);
  for (std::size_t r = 0; r < rings.size(); ++r) {
    EXPECT_NEAR(to_deg(rings[r].elevation_rad), -15.0 + 2.0 * static_cast<double>(r), 1e-3);
    EXPECT_NEAR(to_deg(rings[r].step_rad), 0.2, 1e-6);
    EXPECT_EQ(rings[r].points.size(), 1800u);
    EXPECT_TRUE(std::is_sorted(rings[r].azimuth_rad.begin(), rings[r].azimuth_rad.end()));
  }
  EXPECT_EQ(split_rings(points, true, 0.4).size(), 16u);
}

TEST(LidarRings, KnowTheNoiseOfTheirRanges) {
  Random random(6);
  const std::vector<SE3> plate{plate_at(0.3, 2.0, 0.7, 0.1)};
  for (const double sigma : {0.0, 0.004, 0.02}) {
    EXPECT_NEAR(range_noise(split_rings(ring_scan(plate, {0.85, 0.61}, sigma, random), true, 0.4)), sigma,
                0.03 * sigma + 1e-6);
  }
  EXPECT_EQ(range_noise({}), 0.0);
}

TEST(LidarRings, AreNotSeenWherePointsLieAtAllElevations) {
  Random random(2);
  std::vector<Point> points(5000);
  for (Point& p : points) {
    p.x = 5.0F;
    p.y = static_cast<float>(random.uniform(-1.0, 1.0));
    p.z = static_cast<float>(random.uniform(-1.0, 1.0));
  }
  EXPECT_TRUE(split_rings(points, false, 0.4).empty());
  EXPECT_TRUE(split_rings({}, false, 0.4).empty());
  EXPECT_TRUE(split_rings({}, true, 0.4).empty());
}

TEST(RingBoards, FindsAPlateWhereverItStands) {
  Random random(3);
  const BoardModel board = make_board();
  int found = 0;
  for (int trial = 0; trial < 12; ++trial) {
    // Behind the sensor, too, where azimuth jumps from one end of its range to the other.
    const double azimuth = trial < 6 ? pi + 0.1 * (trial - 3) : random.uniform(-1.0, 1.0);
    const SE3 T = plate_at(azimuth, random.uniform(1.7, 3.2), random.uniform(0.4, 1.1), random.uniform(-0.4, 0.4));
    const CloudBoards seen = find_ring_boards(ring_scan({T}, board.size(), 0.012, random), board, false);
    ASSERT_EQ(seen.boards.size(), 1u) << trial << seen.why_none;
    double nearest = 1e9;
    for (const SE3& turn : board.plate_turns()) {
      nearest = std::min(nearest, board.corner_distance(seen.boards[0].T_lidar_board * turn, T));
    }
    EXPECT_LT(nearest, 0.03) << trial;
    EXPECT_NEAR(seen.boards[0].plane_rms_m, 0.011, 0.003);
    EXPECT_GT(seen.boards[0].overlap, 0.9);
    found += nearest < 0.015 ? 1 : 0;
  }
  EXPECT_GE(found, 9);
}

TEST(RingBoards, FindsAPlateInNoiseThatStraysBeyondAnyFixedTolerance) {
  Random random(7);
  const BoardModel board = make_board();
  for (int trial = 0; trial < 10; ++trial) {
    const SE3 T = plate_at(random.uniform(-1.0, 1.0), random.uniform(1.9, 3.0), random.uniform(0.5, 1.0), 0.2);
    const CloudBoards seen = find_ring_boards(ring_scan({T}, board.size(), 0.022, random), board, true);
    ASSERT_EQ(seen.boards.size(), 1u) << trial << seen.why_none;
    EXPECT_LT((seen.boards[0].T_lidar_board.t - T.t).norm(), 0.03) << trial;
  }
}

// A stop of some seconds: columns that come again at the same azimuths, or wherever the motor is.
TEST(RingBoards, FindsAPlateInManyRevolutions) {
  Random random(8);
  const BoardModel board = make_board();
  const SE3 T = plate_at(0.3, 2.2, 0.7, 0.2);
  for (const bool same_azimuths : {true, false}) {
    for (const int revolutions : {2, 20}) {
      std::vector<Point> all;
      for (int k = 0; k < revolutions; ++k) {
        const SE3 turn{exp_so3({0.0, 0.0, same_azimuths ? 0.0 : to_rad(0.2) * random.uniform()}), Vector3d::Zero()};
        for (Point p : ring_scan({turn.inverse() * T}, board.size(), 0.012, random)) {
          const Vector3d q = turn * Vector3d(p.x, p.y, p.z);
          p.x = static_cast<float>(q.x());
          p.y = static_cast<float>(q.y());
          all.push_back(p);
        }
      }
      for (const bool rings_in_shot : {false, true}) {
        const CloudBoards seen = find_ring_boards(all, board, rings_in_shot);
        ASSERT_EQ(seen.boards.size(), 1u) << same_azimuths << revolutions << seen.why_none;
        double nearest = 1e9;
        for (const SE3& turned : board.plate_turns()) {
          nearest = std::min(nearest, board.corner_distance(seen.boards[0].T_lidar_board * turned, T));
        }
        EXPECT_LT(nearest, 0.015) << same_azimuths << revolutions;
      }
    }
  }
}

TEST(RingBoards, FindsTwoPlatesAndSaysSoWhereThereIsNone) {
  Random random(4);
  const BoardModel board = make_board();
  const std::vector<SE3> two{plate_at(0.0, 2.0, 0.8, 0.1), plate_at(1.5, 2.5, 0.7, -0.2)};
  EXPECT_EQ(find_ring_boards(ring_scan(two, board.size(), 0.012, random), board, false).boards.size(), 2u);
  const CloudBoards none = find_ring_boards(ring_scan({}, board.size(), 0.012, random), board, false);
  EXPECT_TRUE(none.boards.empty());
  EXPECT_NE(none.why_none.find("no flat piece of 0.85 by 0.61 m"), std::string::npos) << none.why_none;
}

TEST(RingBoards, TellsTheSizeOfAPlateThatIsNotTheRigFiles) {
  Random random(5);
  const CloudBoards seen =
      find_ring_boards(ring_scan({plate_at(0.2, 2.0, 0.7, 0.1)}, {1.2, 0.9}, 0.012, random), make_board(), false);
  EXPECT_TRUE(seen.boards.empty());
  EXPECT_NE(seen.why_none.find("correct its size in the rig file"), std::string::npos) << seen.why_none;
}

}  // namespace
}  // namespace rigcal
