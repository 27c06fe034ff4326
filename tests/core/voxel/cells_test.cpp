#include "core/voxel/cells.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>

#include "core/base/random.h"
#include "tests/core/voxel/random_points.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

using Voxel = std::array<long, 3>;

Voxel voxel_of(const Point& p, double size) {
  return {std::lround(std::floor(p.x / size)), std::lround(std::floor(p.y / size)),
          std::lround(std::floor(p.z / size))};
}

// The voxels in the order in which they are first hit, with their points.
std::vector<std::vector<Vector3d>> sorted_by_hand(const std::vector<Point>& points, double size) {
  std::map<Voxel, std::size_t> place;
  std::vector<std::vector<Vector3d>> voxels;
  for (const Point& p : points) {
    const auto [at, is_new] = place.try_emplace(voxel_of(p, size), voxels.size());
    if (is_new) voxels.emplace_back();
    voxels[at->second].push_back(vector_of(p));
  }
  return voxels;
}

void expect_same_bits(const PatchCells& a, const PatchCells& b) {
  EXPECT_EQ(a.points, b.points);
  ASSERT_EQ(a.cells.size(), b.cells.size());
  EXPECT_TRUE(a.cells == b.cells);
  ASSERT_EQ(a.pieces.size(), b.pieces.size());
  EXPECT_TRUE(a.pieces == b.pieces);
  ASSERT_EQ(a.thinned.size(), b.thinned.size());
  EXPECT_EQ(0, std::memcmp(a.thinned.data(), b.thinned.data(), a.thinned.size() * sizeof(Point)));
}

TEST(Cells, HaveTheCountMeanAndScatterOfTheirPointsInTheOrderOfTheFirstHits) {
  // 20000 points in about 4000 voxels: the table grows on the way.
  const std::vector<Point> points = random_points(20000, 2.0, 1);
  const PatchCells patch = cells_of(points, 3, 7, CellOptions{0.25, 60.0, false});
  const auto expected = sorted_by_hand(points, 0.25);
  EXPECT_EQ(3, patch.lidar);
  EXPECT_EQ(7, patch.stop);
  EXPECT_EQ(points.size(), patch.points);
  EXPECT_TRUE(patch.thinned.empty());
  ASSERT_EQ(expected.size(), patch.cells.size());
  ASSERT_GT(expected.size(), 2048U);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Cell& cell = patch.cells[i];
    ASSERT_EQ(static_cast<double>(expected[i].size()), cell.N);
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : expected[i]) mean += p / cell.N;
    Matrix3d scatter = Matrix3d::Zero();
    for (const Vector3d& p : expected[i]) scatter += (p - mean) * (p - mean).transpose();
    // Some ten sums of numbers below 4: rounding only.
    EXPECT_LT((cell.mean - mean).norm(), 1e-14);
    EXPECT_LT((cell.scatter_matrix() - scatter).norm(), 1e-14);
  }
}

TEST(Cells, LoseNoDigitsFarFromTheSensor) {
  // A thousand points within a millimetre, 55 m away: sums about the sensor would lose their scatter in rounding.
  Random random(2);
  std::vector<Point> points;
  Matrix3d scatter = Matrix3d::Zero();
  Vector3d mean = Vector3d::Zero();
  const Vector3d center(40.05, -37.85, 3.05);
  for (int i = 0; i < 1000; ++i) {
    const double dx = 1e-3 * random.normal();
    const double dy = 1e-3 * random.normal();
    points.push_back(point(center.x() + dx, center.y() + dy, center.z()));
    mean += vector_of(points.back()) / 1000.0;
  }
  for (const Point& p : points) scatter += (vector_of(p) - mean) * (vector_of(p) - mean).transpose();
  const PatchCells patch = cells_of(points, 0, 0);
  ASSERT_EQ(1U, patch.cells.size());
  // Sums about the cell's centre add up to 3, those about the sensor would to 3e6: rounding of 1e-13 or of 1e-8.
  EXPECT_LT((patch.cells[0].scatter_matrix() - scatter).norm(), 1e-12);
}

TEST(Cells, KeepPointsOnBothSidesOfZeroApartAndThoseOnANegativeBorderInTheUpperCell) {
  const CellOptions quarter{0.25, 60.0, false};
  EXPECT_EQ(1U, cells_of({point(-0.01, -0.01, -0.01), point(-0.24, -0.24, -0.24)}, 0, 0, quarter).cells.size());
  EXPECT_EQ(2U, cells_of({point(-0.01, 0.1, 0.1), point(0.01, 0.1, 0.1)}, 0, 0, quarter).cells.size());
  EXPECT_EQ(1U, cells_of({point(0.1, -0.25, 0.1), point(0.1, -0.01, 0.1)}, 0, 0, quarter).cells.size());
  EXPECT_EQ(2U, cells_of({point(0.1, 0.1, -0.25), point(0.1, 0.1, -0.26)}, 0, 0, quarter).cells.size());
  EXPECT_EQ(1U, cells_of({point(0.0, 0.1, 0.1), point(0.01, 0.1, 0.1)}, 0, 0, quarter).cells.size());
}

TEST(Cells, AreTheSameBitsHoweverThePointsAreDealtOut) {
  const std::vector<Point> points = random_points(5000, 1.0, 3);
  const CellOptions options{0.2, 60.0, true};
  const PatchCells whole = cells_of(points, 1, 2, options);
  CellBuilder builder(1, 2, options);
  Random random(4);
  for (std::size_t at = 0; at < points.size();) {
    const std::size_t count = std::min<std::size_t>(random.below(200), points.size() - at);
    builder.add(std::span(points).subspan(at, count));
    at += count;
  }
  expect_same_bits(whole, builder.finish());
}

TEST(Cells, BuilderIsEmptyAfterFinishAndFitForMore) {
  const std::vector<Point> points = random_points(500, 1.0, 5);
  const CellOptions options{0.2, 60.0, true};
  CellBuilder builder(1, 2, options);
  builder.add(points);
  const PatchCells first = builder.finish();
  const PatchCells nothing = builder.finish();
  EXPECT_EQ(0U, nothing.points);
  EXPECT_TRUE(nothing.cells.empty());
  EXPECT_TRUE(nothing.pieces.empty());
  EXPECT_TRUE(nothing.thinned.empty());
  builder.add(points);
  expect_same_bits(first, builder.finish());
}

TEST(Cells, OfABuilderThatIsUsedAgainAreThoseOfANewOne) {
  const CellOptions coarse{0.4, 3.0, true};
  CellBuilder builder(1, 2, CellOptions{});
  builder.add(random_points(30000, 2.0, 21));
  EXPECT_EQ(30000U, builder.finish().points);
  builder.add(random_points(500, 1.0, 22));
  builder.begin(3, 4, coarse);  // the 500 are forgotten
  const std::vector<Point> points = random_points(5000, 4.0, 23);
  builder.add(points);
  const PatchCells again = builder.finish();
  EXPECT_EQ(3, again.lidar);
  EXPECT_EQ(4, again.stop);
  expect_same_bits(cells_of(points, 3, 4, coarse), again);
}

TEST(Cells, LeaveOutWhatIsTooFarAndWhatIsNoNumber) {
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float infinity = std::numeric_limits<float>::infinity();
  std::vector<Point> points{point(3, 4, 0), point(0, 0, 4.999), point(-5.001, 0, 0), point(3, 3, 3),
                            point(0, -1e30, 0)};
  points.push_back({nan, 0.0F, 0.0F});
  points.push_back({0.0F, infinity, 0.0F});
  points.push_back({1.0F, 1.0F, -infinity});
  // 5 m is too far already: (3, 4, 0) stays out, only (0, 0, 4.999) is in.
  const PatchCells patch = cells_of(points, 0, 0, CellOptions{0.2, 5.0, true});
  EXPECT_EQ(1U, patch.points);
  EXPECT_EQ(7U, patch.too_far);
  ASSERT_EQ(1U, patch.cells.size());
  EXPECT_EQ(1U, patch.pieces.size());
  EXPECT_FLOAT_EQ(4.999F, static_cast<float>(patch.cells[0].mean.z()));
  EXPECT_EQ(1U, patch.thinned.size());
}

class ThinnedCells : public ::testing::TestWithParam<double> {};

TEST_P(ThinnedCells, KeepTheFirstPointOfEveryTwoCentimetreCube) {
  const double size = GetParam();
  // 40000 points in a cube of 0.6 m, that is 27000 small cubes: most are met, many more than once.
  const std::vector<Point> points = random_points(40000, 0.3, 6);
  const PatchCells patch = cells_of(points, 0, 0, CellOptions{size, 60.0, true});
  std::set<Voxel> seen;
  std::vector<Point> expected;
  for (const Point& p : points) {
    if (seen.insert(voxel_of(p, 0.02)).second) expected.push_back(p);
  }
  ASSERT_EQ(expected.size(), patch.thinned.size());
  EXPECT_EQ(0, std::memcmp(expected.data(), patch.thinned.data(), expected.size() * sizeof(Point)));
}

// Multiples of 2 cm, whose small cubes are those of the whole space.
INSTANTIATE_TEST_SUITE_P(Sizes, ThinnedCells, ::testing::Values(0.2, 0.1));

TEST(Cells, OfHalfAMetreAreThinnedToATenthOfTheirEdge) {
  const std::vector<Point> points = random_points(20000, 0.5, 7);
  const PatchCells patch = cells_of(points, 0, 0, CellOptions{0.5, 60.0, true});
  ASSERT_EQ(8U, patch.cells.size());
  std::set<Voxel> cubes;
  for (const Point& p : points) cubes.insert(voxel_of(p, 0.05));
  EXPECT_EQ(cubes.size(), patch.thinned.size());
}

}  // namespace
}  // namespace rigcal
