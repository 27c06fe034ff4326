#include "core/board/squares_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "core/base/random.h"

namespace rigcal {
namespace {

using Eigen::Vector2d;

// The pattern's middle is not the plate's.
BoardModel make_board() { return BoardModel({"checkerboard", {7, 4}, 0.1, {1.0, 0.7}, {0.02, -0.01}}); }

// Reflectivities of a pattern that lies at `place`, each the mean over a footprint of 12 by 4 mm.
std::vector<SquareSpot> spots_of(const BoardModel& board, const SquaresPlace& place, int count, Random& random) {
  std::vector<SquareSpot> out;
  const Eigen::Rotation2Dd to_board(-place.angle_rad);
  for (int k = 0; k < count; ++k) {
    SquareSpot spot;
    spot.at = {0.5 * random.uniform(-1.0, 1.0), 0.35 * random.uniform(-1.0, 1.0)};
    double bright = 0.0;
    for (int part = 0; part < 8; ++part) {
      const Vector2d look = spot.at + Vector2d(0.006 * random.uniform(-1.0, 1.0), 0.002 * random.uniform(-1.0, 1.0));
      const Vector2d q = to_board * ((look - place.shift) / place.scale);
      bright += board.colour_at(q.x(), q.y(), 0.0) == 1 ? 0.0 : 0.125;
    }
    spot.reflectivity = 10.0 + 60.0 * bright + 5.0 * random.normal();
    out.push_back(spot);
  }
  return out;
}

TEST(SquaresFit, FindsPlaceTurnAndSizeOfTheSquares) {
  Random random(1);
  const BoardModel board = make_board();
  for (int trial = 0; trial < 5; ++trial) {
    SquaresPlace truth;
    truth.shift = {0.02 * random.uniform(-1.0, 1.0), 0.02 * random.uniform(-1.0, 1.0)};
    truth.angle_rad = 0.02 * random.uniform(-1.0, 1.0);
    truth.scale = 1.0 + 0.01 * random.uniform(-1.0, 1.0);
    const auto fit = fit_squares(spots_of(board, truth, 8000, random), board, {});
    ASSERT_TRUE(fit);
    EXPECT_LT((fit->place.shift - truth.shift).norm(), 0.0006);
    EXPECT_NEAR(fit->place.angle_rad, truth.angle_rad, 0.0015);
    EXPECT_NEAR(fit->place.scale, truth.scale, 0.002);
    EXPECT_NEAR(fit->place.scale, truth.scale, 4.0 * fit->scale_sigma);
    EXPECT_LT(fit->scale_sigma, 0.001);
    EXPECT_GT(fit->blur_m, 0.001);
  }
}

TEST(SquaresFit, FindsNothingOnAPlainPlateOrInAFewPoints) {
  Random random(2);
  const BoardModel board = make_board();
  auto spots = spots_of(board, {}, 4000, random);
  EXPECT_TRUE(fit_squares(spots, board, {}));
  EXPECT_FALSE(fit_squares(std::vector<SquareSpot>(spots.begin(), spots.begin() + 100), board, {}));
  EXPECT_FALSE(fit_squares({}, board, {}));
  for (SquareSpot& spot : spots) spot.reflectivity = 40.0 + 5.0 * random.normal();
  EXPECT_FALSE(fit_squares(spots, board, {}));
}

}  // namespace
}  // namespace rigcal
