#include "core/voxel/range_correction.h"

#include <gtest/gtest.h>

#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

TEST(RangeCorrection, OfCellsIsThatOfTheirPoints) {
  constexpr double too_long_m = 0.03;
  Random random(1);
  const std::vector<Point> seen = see(make_room(), SE3{}, View{300.0, pi, NoiseModel{0.01, 0.0, 0.0005}}, random);
  std::vector<Point> lengthened = seen;
  for (Point& p : lengthened) {
    const Eigen::Vector3f at(p.x, p.y, p.z);
    const Eigen::Vector3f moved = at + static_cast<float>(too_long_m) * at.normalized();
    p.x = moved.x();
    p.y = moved.y();
    p.z = moved.z();
  }

  CellOptions options;
  options.keep_thinned = true;
  PatchCells corrected = cells_of(lengthened, 0, 0, options);
  const std::vector<Point> thinned = corrected.thinned;
  shorten_ranges(corrected, {too_long_m, 0.0});
  Vector3d sum = Vector3d::Zero();
  Matrix3d scatter = Matrix3d::Zero();
  for (const Cell& cell : corrected.cells) {
    sum += cell.N * cell.mean;
    scatter += cell.scatter_matrix() + cell.N * cell.mean * cell.mean.transpose();
  }
  Vector3d sum_of_pieces = Vector3d::Zero();
  for (const Cell& piece : corrected.pieces) sum_of_pieces += piece.N * piece.mean;
  EXPECT_LT((sum_of_pieces - sum).norm(), 1e-4 * static_cast<double>(seen.size()));
  Vector3d true_sum = Vector3d::Zero();
  Matrix3d true_scatter = Matrix3d::Zero();
  for (const Point& p : seen) {
    const Vector3d at(p.x, p.y, p.z);
    true_sum += at;
    true_scatter += at * at.transpose();
  }
  EXPECT_LT((sum - true_sum).norm(), 1e-4 * static_cast<double>(seen.size()));
  EXPECT_LT((scatter - true_scatter).norm(), 1e-4 * true_scatter.norm());
  ASSERT_EQ(corrected.thinned.size(), thinned.size());
  for (std::size_t i = 0; i < thinned.size(); ++i) {
    const Eigen::Vector3f before(thinned[i].x, thinned[i].y, thinned[i].z);
    const Eigen::Vector3f after(corrected.thinned[i].x, corrected.thinned[i].y, corrected.thinned[i].z);
    EXPECT_NEAR(before.norm() - after.norm(), too_long_m, 1e-5);
    EXPECT_LT(before.normalized().cross(after.normalized()).norm(), 1e-6);
  }
}

// Dark points stand farther off the sensor than bright ones, in every piece by as much as its own.
TEST(RangeCorrection, GoesByTheDarknessOfEachPiece) {
  constexpr RangeError error{0.01, 0.02};
  Random random(2);
  std::vector<Point> points = see(make_room(), SE3{}, View{300.0, pi, NoiseModel{0.01, 0.0, 0.0005}}, random);
  for (Point& p : points) p.reflectivity = p.y < 0.0F ? 0 : (p.z < 0.0F ? 40 : 180);
  CellOptions options;
  options.keep_thinned = true;
  const PatchCells before = cells_of(points, 0, 0, options);
  PatchCells after = before;
  shorten_ranges(after, error);
  const auto darkness_at = [](const Vector3d& p) { return p.y() < 0.0 ? 1.0 : (p.z() < 0.0 ? 0.6 : 0.0); };
  double mean = 0.0;
  for (std::size_t i = 0; i < before.pieces.size(); ++i) {
    const Cell& piece = before.pieces[i];
    mean += piece.N * piece.darkness / static_cast<double>(points.size());
    EXPECT_NEAR(piece.darkness, darkness_at(piece.mean), 1e-6);
    EXPECT_NEAR(piece.mean.norm() - after.pieces[i].mean.norm(), error.at(darkness_at(piece.mean)), 1e-9);
  }
  for (std::size_t i = 0; i < before.cells.size(); ++i) {
    EXPECT_NEAR(before.cells[i].mean.norm() - after.cells[i].mean.norm(), error.at(mean), 1e-9);
  }
  for (std::size_t i = 0; i < before.thinned.size(); ++i) {
    const Point& p = before.thinned[i];
    const Eigen::Vector3f at(p.x, p.y, p.z);
    const Eigen::Vector3f moved(after.thinned[i].x, after.thinned[i].y, after.thinned[i].z);
    EXPECT_NEAR(at.norm() - moved.norm(), error.at(darkness_at(at.cast<double>())), 1e-5);
  }
}

}  // namespace
}  // namespace rigcal
