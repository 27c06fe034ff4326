#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>
#include <utility>

#include "core/base/random.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/cells.h"
#include "tests/core/voxel/random_points.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

// A cell as the sensor sees it: which way it looks, how far left and up, how deep.
using Direction = std::array<long, 4>;

Direction direction_of(const Point& p, double size) {
  const Vector3d v = vector_of(p);
  int axis = 0;
  const double depth = v.cwiseAbs().maxCoeff(&axis);
  const long deep = std::lround(std::floor(depth / size));
  long across = 1;
  for (double end = 1.0; across <= deep; across = std::lround(end)) end *= std::sqrt(2.0);
  const auto at = [&](int other) {
    return std::lround(std::floor(v[(axis + other) % 3] / depth * static_cast<double>(across)));
  };
  return {v[axis] < 0.0 ? 2L * axis + 1 : 2L * axis, at(1), at(2), deep};
}

TEST(Pieces, HaveTheCountMeanAndScatterOfTheirPointsInTheOrderOfTheirDirections) {
  // Some thousand cells, and in each too few points to divide it. Every other depth is empty, so that none go together
  // with the next.
  constexpr double size = 0.25;
  std::vector<Point> points = random_points(9000, 2.0, 1);
  std::erase_if(points, [](const Point& p) { return direction_of(p, size)[3] % 2 == 0; });
  std::map<Direction, std::vector<Vector3d>> all;
  for (const Point& p : points) all[direction_of(p, size)].push_back(vector_of(p));
  std::erase_if(points, [&](const Point& p) { return all[direction_of(p, size)].size() > 7; });
  std::map<Direction, std::vector<Vector3d>> expected;
  for (const Point& p : points) expected[direction_of(p, size)].push_back(vector_of(p));
  const PatchCells patch = cells_of(points, 3, 7, CellOptions{size, 60.0, false});
  ASSERT_GT(expected.size(), 1000U);
  ASSERT_EQ(expected.size(), patch.pieces.size());
  auto piece = patch.pieces.begin();
  for (const auto& [direction, own] : expected) {
    ASSERT_EQ(static_cast<double>(own.size()), piece->N);
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : own) mean += p / piece->N;
    Matrix3d scatter = Matrix3d::Zero();
    for (const Vector3d& p : own) scatter += (p - mean) * (p - mean).transpose();
    EXPECT_LT((piece->mean - mean).norm(), 1e-14);
    EXPECT_LT((piece->scatter_matrix() - scatter).norm(), 1e-13);
    ++piece;
  }
}

TEST(Pieces, KeepDirectionsApart) {
  const auto count = [](const std::vector<Point>& points) { return cells_of(points, 0, 0).pieces.size(); };
  EXPECT_EQ(1U, count({point(2.01, 0.01, 0.01), point(2.19, 0.12, 0.12)}));
  EXPECT_EQ(2U, count({point(2.01, -0.01, 0.1), point(2.01, 0.01, 0.1)})) << "left and right of the middle";
  EXPECT_EQ(2U, count({point(2.01, 0.1, -0.01), point(2.01, 0.1, 0.01)})) << "below and above";
  EXPECT_EQ(2U, count({point(2.01, 0.01, 0.01), point(-2.01, 0.01, 0.01)})) << "before and behind";
  EXPECT_EQ(2U, count({point(2.01, 2.02, 0.01), point(2.02, 2.01, 0.01)})) << "on both sides of 45 degrees";
  EXPECT_EQ(2U, count({point(2.05, 0.01, 0.01), point(2.35, 0.01, 0.01)})) << "one behind the other";
  EXPECT_EQ(1U, count({point(2.395, 0.01, 0.01), point(2.405, 0.01, 0.01)})) << "one surface, cut by its noise";
  EXPECT_EQ(2U, count({point(2.395, 0.01, 0.01), point(2.405, 0.12, 0.01)})) << "one surface, that goes on behind";
  EXPECT_EQ(2U, count({point(2.195, 0.01, 0.01), point(2.205, 0.01, 0.01)})) << "other directions from there on";
  EXPECT_EQ(1U, count({point(0.0, 0.0, 0.0), point(0.01, 0.0, 0.0)}));
}

// Noise moves a point along its ray. Cells whose borders lie across rays would take some of a wall's points by their
// noise, and their means would stand off by several times what their number lets expect. A wall that is turned away is
// still cut so where it goes from one depth to the next, and any where the number of cells across changes with the
// depth: that is not here.
class NoisyWall : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(NoisyWall, HasPiecesThatStandOffNoMoreThanTheirNumberLetsExpect) {
  constexpr double sigma = 0.016;
  const auto [turned_deg, most] = GetParam();
  Random random(11 + static_cast<std::uint64_t>(turned_deg));
  const Vector3d normal(std::cos(to_rad(turned_deg)), std::sin(to_rad(turned_deg)), 0.0);
  const double distance = 3.8 * normal.x();  // where one depth ends and the next begins
  std::vector<Point> points;
  for (int i = 0; i < 20000; ++i) {
    const Vector3d ray = Vector3d(1.0, random.uniform(-0.15, 0.15), random.uniform(-0.3, 0.3)).normalized();
    const Vector3d p = (distance / normal.dot(ray) + sigma * random.normal()) * ray;
    points.push_back(point(p.x(), p.y(), p.z()));
  }
  double sum = 0.0;
  double pieces = 0.0;
  for (const Cell& piece : cells_of(points, 0, 0).pieces) {
    if (piece.N < 20.0) continue;
    const double along = normal.dot(piece.mean.normalized());
    sum += piece.N * std::pow((normal.dot(piece.mean) - distance) / (sigma * along), 2);
    pieces += 1.0;
  }
  EXPECT_GT(pieces, 60.0);
  EXPECT_LT(sum / pieces, most);
}

// Degrees, and a bound: cells that never go together with what lies behind give 46, 16, 10 and 5.
INSTANTIATE_TEST_SUITE_P(Turned, NoisyWall,
                         testing::Values(std::pair(0.0, 1.6), std::pair(10.0, 1.6), std::pair(25.0, 3.5),
                                         std::pair(40.0, 3.0)));

// What a surface's borders across the rays do to its pieces, as far as the noise of ranges says it.
struct NoiseOf {
  explicit NoiseOf(const Cell& piece)
      : ray(piece.mean.normalized()), shift(piece.noise_shift_per_m * sigma * sigma * ray) {}

  static constexpr double sigma = 0.016;  // m
  Vector3d ray;
  Vector3d shift;  // of the mean
};

class TurnedWall : public testing::TestWithParam<double> {};

TEST_P(TurnedWall, HasPiecesThatStandOffByTheirNumberAloneOnceShiftsAreUndone) {
  const double turn = to_rad(GetParam());
  Random random(5 + static_cast<std::uint64_t>(GetParam()));
  const Vector3d normal(std::cos(turn), std::sin(turn), 0.0);
  const double distance = 3.75 * normal.x();
  double as_it_is = 0.0;
  double undone = 0.0;
  double pieces = 0.0;
  for (int patch = 0; patch < 5; ++patch) {
    std::vector<Point> points;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d ray = Vector3d(1.0, random.uniform(-0.15, 0.15), random.uniform(-0.3, 0.3)).normalized();
      const Vector3d p = (distance / normal.dot(ray) + NoiseOf::sigma * random.normal()) * ray;
      points.push_back(point(p.x(), p.y(), p.z()));
    }
    for (const Cell& piece : cells_of(points, 0, 0).pieces) {
      const NoiseOf noise(piece);
      const double variance = std::pow(NoiseOf::sigma * normal.dot(noise.ray), 2) / piece.N;
      as_it_is += std::pow(normal.dot(piece.mean) - distance, 2) / variance;
      undone += std::pow(normal.dot(piece.mean - noise.shift) - distance, 2) / variance;
      pieces += 1.0;
    }
  }
  EXPECT_GT(as_it_is / pieces, 1.6);
  EXPECT_LT(undone / pieces, 1.45);
}

// A wall that is met straight stands where its points do on average, however near to a border between depths: what
// noise takes from one side it gives to the other.
class StraightWall : public testing::TestWithParam<double> {};

TEST_P(StraightWall, StandsWhereItsPointsDo) {
  const double distance = GetParam();
  for (const int count : {2'000, 20'000, 200'000}) {
    Random random(static_cast<std::uint64_t>(count));
    std::vector<Point> points;
    for (int i = 0; i < count; ++i) {
      const Vector3d ray = Vector3d(1.0, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)).normalized();
      const Vector3d p = (distance / ray.x() + NoiseOf::sigma * random.normal()) * ray;
      points.push_back(point(p.x(), p.y(), p.z()));
    }
    double sum = 0.0;
    for (const Cell& piece : cells_of(points, 0, 0).pieces)
      sum += piece.N * (piece.mean.x() - NoiseOf(piece).shift.x() - distance);
    EXPECT_NEAR(sum / count, 0.0, 4.0 * NoiseOf::sigma / std::sqrt(count)) << count << " points";
  }
}

// Borders at 6.4 and 9 m, where the number of cells across changes, and at 9.2 m, where it does not.
INSTANTIATE_TEST_SUITE_P(ByDistance, StraightWall,
                         testing::Values(6.38, 6.42, 8.97, 8.984, 9.016, 9.03, 9.17, 9.184, 9.216, 9.23));

INSTANTIATE_TEST_SUITE_P(ByDegrees, TurnedWall, testing::Values(30.0, 50.0));

// Points of a strip of a level floor below the sensor, with noise along the rays.
std::vector<Point> strip_of_floor(double from_m, double to_m, double height_m, Random& random) {
  std::vector<Point> points;
  for (int i = 0; i < 20000; ++i) {
    const double x = random.uniform(from_m, to_m);
    const Vector3d p(x, random.uniform(-0.4, 0.4) * x, -height_m);
    const Vector3d seen = p + NoiseOf::sigma * random.normal() * p.normalized();
    points.push_back(point(seen.x(), seen.y(), seen.z()));
  }
  return points;
}

class GrazedFloor : public testing::TestWithParam<double> {};

// Weights that go with the place of a point go with its noise: what is taken out of the scatter then turns the floor.
TEST_P(GrazedFloor, IsNotTurnedByNoiseHoweverItsPiecesAreWeighed) {
  const double from = GetParam();
  const double to = 1.35 * from;
  constexpr double height = 1.2;
  Random random(17);
  double plain = 0.0;  // taken out in full, means as they are
  double told = 0.0;   // by the pieces' own shares and shifts
  double all = 0.0;
  for (int patch = 0; patch < 30; ++patch) {
    for (const Cell& piece : cells_of(strip_of_floor(from, to, height, random), 0, 0).pieces) {
      const double place = (piece.mean.x() - from) / (to - from);
      if (place < 0.0 || place > 1.0) continue;
      const NoiseOf noise(piece);
      const Vector3d outward = Vector3d(piece.mean.x(), piece.mean.y(), 0.0).normalized();
      const double arm = piece.N * (outward.dot(piece.mean) - 0.5 * (from + to));
      const double off = piece.mean.z() + height;
      const double weight = std::pow(std::sin(pi * place), 2);
      const double torque = Vector3d::UnitZ().dot(piece.scatter_matrix() * outward);
      const double of_noise = piece.N * std::pow(NoiseOf::sigma, 2) * noise.ray.z() * noise.ray.dot(outward);
      plain += weight * (arm * off + torque - of_noise);
      told += weight * (arm * (off - noise.shift.z()) + torque - piece.noise_share * of_noise);
      all += weight * of_noise;
    }
  }
  EXPECT_GT(std::abs(plain / all), 0.15);
  EXPECT_LT(std::abs(told), 0.5 * std::abs(plain));
  EXPECT_NEAR(0.0, told / all, 0.12);
}

// Metres; at 2.2 m the number of cells across changes with the depth.
INSTANTIATE_TEST_SUITE_P(ByDistance, GrazedFloor, testing::Values(2.0, 4.0, 6.0));

// Points of a wall three metres ahead, and where asked for of the floor that it stands on, with noise of a centimetre
// along rays. The corner lies in the middle of cells.
std::vector<Point> floor_and_wall(bool with_floor, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (int i = 0; i < 40000; ++i) {
    const double y = random.uniform(-1.0, 1.0);
    const Vector3d p = with_floor && i % 2 == 1 ? Vector3d(random.uniform(1.5, 3.1), y, -1.26)
                                                : Vector3d(3.1, y, random.uniform(-1.26, 0.0));
    const Vector3d seen = p + 0.01 * random.normal() * p.normalized();
    points.push_back(point(seen.x(), seen.y(), seen.z()));
  }
  return points;
}

// How many pieces are made where one cell would hold all, on the average over the cells of some place.
double pieces_for_each_cell(const std::vector<Point>& points, const std::function<bool(const Vector3d&)>& is_there) {
  std::set<Direction> directions;
  for (const Point& p : points) {
    if (is_there(vector_of(p))) directions.insert(direction_of(p, CellOptions{}.size_m));
  }
  const PatchCells patch = cells_of(points, 0, 0);
  const auto pieces = std::count_if(patch.pieces.begin(), patch.pieces.end(),
                                    [&](const Cell& piece) { return piece.N > 1.0 && is_there(piece.mean); });
  EXPECT_GT(directions.size(), 9U);
  return static_cast<double>(pieces) / static_cast<double>(directions.size());
}

TEST(Pieces, AreSmallWhereTwoSurfacesMeet) {
  const auto in_corner = [](const Vector3d& p) { return p.x() > 3.0 && p.z() < -1.2; };
  const auto on_wall = [](const Vector3d& p) { return p.z() > -1.1; };
  EXPECT_GT(pieces_for_each_cell(floor_and_wall(true, 8), in_corner), 3.0);
  EXPECT_LT(pieces_for_each_cell(floor_and_wall(false, 9), on_wall), 2.0) << "most flat ones stay whole";
}

TEST(Pieces, OfACornerAreAsThinAsItsSurfaces) {
  const PatchCells patch = cells_of(floor_and_wall(true, 12), 0, 0);
  double thin = 0.0;
  double all = 0.0;
  for (const Cell& piece : patch.pieces) {
    if (piece.N < 20.0 || piece.mean.x() < 2.9 || piece.mean.z() > -1.1) continue;
    all += piece.N;
    if (symmetric_eigen_fast(piece.scatter_matrix()).values[0] < piece.N * 0.013 * 0.013) thin += piece.N;
  }
  EXPECT_GT(all, 1000.0);
  EXPECT_GT(thin, 0.9 * all);
}

TEST(Pieces, HaveAllPointsThatCubesHave) {
  const PatchCells patch = cells_of(floor_and_wall(true, 10), 0, 0);
  PointCluster of_cubes;
  PointCluster of_pieces;
  const auto add = [](PointCluster& sum, const Cell& cell) {
    sum += {cell.N, cell.N * cell.mean, cell.scatter_matrix() + cell.N * cell.mean * cell.mean.transpose()};
  };
  for (const Cell& cell : patch.cells) add(of_cubes, cell);
  for (const Cell& piece : patch.pieces) add(of_pieces, piece);
  EXPECT_EQ(static_cast<double>(patch.points), of_pieces.N);
  EXPECT_EQ(of_cubes.N, of_pieces.N);
  EXPECT_LT((of_cubes.mean() - of_pieces.mean()).norm(), 1e-12);
  EXPECT_LT((of_cubes.covariance() - of_pieces.covariance()).norm(), 1e-12);
}

// What is too much to wait is kept as sums on the way, twice here. The same points alone all wait.
TEST(Pieces, AreTheSameBitsHoweverManyPointsComeBetween) {
  std::vector<Point> points = floor_and_wall(true, 14);
  for (std::size_t i = 0; i < points.size(); ++i) points[i].reflectivity = static_cast<std::uint8_t>(i);
  const std::vector<Cell> alone = cells_of(points, 0, 0).pieces;
  Random random(15);
  std::vector<Point> all;
  for (const Point& p : points) {
    all.push_back(p);
    for (int i = 0; i < 15; ++i) all.push_back(point(-3.0, random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)));
  }
  const PatchCells patch = cells_of(all, 0, 0);
  EXPECT_EQ(640'000U, patch.points);
  double n = 0.0;
  for (const Cell& piece : patch.pieces) n += piece.N;
  EXPECT_EQ(640'000.0, n);
  ASSERT_GT(alone.size(), 500U);
  ASSERT_GT(patch.pieces.size(), alone.size());
  // What lies ahead along x comes before what lies behind.
  EXPECT_TRUE(std::equal(alone.begin(), alone.end(), patch.pieces.begin()));
}

TEST(Pieces, OfFewPointsStayWhole) {
  const PatchCells patch = cells_of({point(3.01, 0.01, 0.01), point(3.19, 0.12, 0.01), point(3.01, 0.12, 0.12),
                                     point(3.19, 0.01, 0.12), point(3.01, 0.01, 0.12)},
                                    0, 0);
  EXPECT_EQ(1U, patch.pieces.size());
}

}  // namespace
}  // namespace rigcal
