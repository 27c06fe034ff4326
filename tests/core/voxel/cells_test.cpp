#include "core/voxel/cells.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <set>

#include "core/base/random.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

using Voxel = std::array<long, 3>;

Point point(double x, double y, double z) {
  Point p;
  p.x = static_cast<float>(x);
  p.y = static_cast<float>(y);
  p.z = static_cast<float>(z);
  return p;
}

Vector3d vector_of(const Point& p) { return {p.x, p.y, p.z}; }

std::vector<Point> random_points(std::size_t count, double reach, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (std::size_t i = 0; i < count; ++i) {
    const double x = random.uniform(-reach, reach);
    const double y = random.uniform(-reach, reach);
    const double z = random.uniform(-reach, reach);
    points.push_back(point(x, y, z));
  }
  return points;
}

Voxel voxel_of(const Point& p, double size) {
  return {std::lround(std::floor(p.x / size)), std::lround(std::floor(p.y / size)),
          std::lround(std::floor(p.z / size))};
}

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

void expect_same_bits(const PatchCells& a, const PatchCells& b) {
  EXPECT_EQ(a.points, b.points);
  ASSERT_EQ(a.cells.size(), b.cells.size());
  EXPECT_EQ(0, std::memcmp(a.cells.data(), b.cells.data(), a.cells.size() * sizeof(Cell)));
  ASSERT_EQ(a.thinned.size(), b.thinned.size());
  EXPECT_EQ(0, std::memcmp(a.thinned.data(), b.thinned.data(), a.thinned.size() * sizeof(Point)));
}

TEST(Cells, HaveTheCountMeanAndScatterOfTheirPointsInTheOrderOfTheirDirections) {
  // 20000 points in some thousand cells: the table grows on the way. Every other depth is empty, so that none go
  // together with the next.
  constexpr double size = 0.25;
  std::vector<Point> points = random_points(40000, 2.0, 1);
  std::erase_if(points, [](const Point& p) { return direction_of(p, size)[3] % 2 == 0; });
  std::map<Direction, std::vector<Vector3d>> expected;
  for (const Point& p : points) expected[direction_of(p, size)].push_back(vector_of(p));
  const PatchCells patch = cells_of(points, 3, 7, CellOptions{size, 60.0, false});
  EXPECT_EQ(3, patch.lidar);
  EXPECT_EQ(7, patch.stop);
  EXPECT_EQ(points.size(), patch.points);
  EXPECT_TRUE(patch.thinned.empty());
  ASSERT_EQ(expected.size(), patch.cells.size());
  ASSERT_GT(expected.size(), 1000U);
  auto cell = patch.cells.begin();
  for (const auto& [direction, own] : expected) {
    ASSERT_EQ(static_cast<double>(own.size()), cell->N);
    Vector3d mean = Vector3d::Zero();
    for (const Vector3d& p : own) mean += p / cell->N;
    Matrix3d scatter = Matrix3d::Zero();
    for (const Vector3d& p : own) scatter += (p - mean) * (p - mean).transpose();
    // Some ten sums of numbers below 4: rounding only.
    EXPECT_LT((cell->mean - mean).norm(), 1e-14);
    EXPECT_LT((cell->scatter_matrix() - scatter).norm(), 1e-13);
    ++cell;
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

TEST(Cells, KeepDirectionsApart) {
  const auto count = [](const std::vector<Point>& points) { return cells_of(points, 0, 0).cells.size(); };
  EXPECT_EQ(1U, count({point(2.01, 0.01, 0.01), point(2.19, 0.12, 0.12)}));
  EXPECT_EQ(2U, count({point(2.01, -0.01, 0.1), point(2.01, 0.01, 0.1)})) << "left and right of the middle";
  EXPECT_EQ(2U, count({point(2.01, 0.1, -0.01), point(2.01, 0.1, 0.01)})) << "below and above";
  EXPECT_EQ(2U, count({point(2.01, 0.01, 0.01), point(-2.01, 0.01, 0.01)})) << "before and behind";
  EXPECT_EQ(2U, count({point(2.01, 2.02, 0.01), point(2.02, 2.01, 0.01)})) << "on both sides of 45 degrees";
  EXPECT_EQ(2U, count({point(2.05, 0.01, 0.01), point(2.95, 0.01, 0.01)})) << "one behind the other";
  EXPECT_EQ(1U, count({point(2.195, 0.01, 0.01), point(2.205, 0.01, 0.01)})) << "one surface, met at a border";
  EXPECT_EQ(1U, count({point(0.0, 0.0, 0.0), point(0.01, 0.0, 0.0)}));
}

// Within one number of cells across: where that changes, at certain depths, walls are cut still. Noise moves a point
// along its ray. Cells whose borders lie across rays would take some of a wall's points by their
// noise, and their means would stand off by several times what their number lets expect.
TEST(Cells, OfANoisyWallStandOffNoMoreThanTheirNumberLetsExpect) {
  constexpr double sigma = 0.016;
  for (const double turned : {0.0, 10.0, 25.0, 40.0}) {
    Random random(11 + static_cast<std::uint64_t>(turned));
    const Vector3d normal(std::cos(to_rad(turned)), std::sin(to_rad(turned)), 0.0);
    const double distance = 3.8 * normal.x();
    std::vector<Point> points;
    for (int i = 0; i < 20000; ++i) {
      const Vector3d ray = Vector3d(1.0, random.uniform(-0.15, 0.15), random.uniform(-0.3, 0.3)).normalized();
      const Vector3d p = (distance / normal.dot(ray) + sigma * random.normal()) * ray;
      points.push_back(point(p.x(), p.y(), p.z()));
    }
    const PatchCells patch = cells_of(points, 0, 0);
    const FinestCells finest(patch);
    double sum = 0.0;
    double cells = 0.0;
    finest.for_each([&](std::uint32_t number) {
      const Cell& cell = finest[number];
      if (cell.N < 20.0) return;
      const double along = normal.dot(cell.mean.normalized());
      sum += cell.N * std::pow((normal.dot(cell.mean) - distance) / (sigma * along), 2);
      cells += 1.0;
    });
    EXPECT_GT(cells, 60.0);
    EXPECT_LT(sum / cells, 1.6) << "a wall turned by " << turned << " degrees";
  }
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
  ASSERT_EQ(1U, patch.cells.size());
  EXPECT_FLOAT_EQ(4.999F, static_cast<float>(patch.cells[0].mean.z()));
  EXPECT_EQ(1U, patch.thinned.size());
}

TEST(Cells, KeepThinnedPointsSomeTwoCentimetresApart) {
  const std::vector<Point> points = random_points(40000, 0.3, 6);
  const PatchCells patch = cells_of(points, 0, 0, CellOptions{0.2, 60.0, true});
  // Some 15 m^3 / 1e6 of small cells, narrower towards the sensor.
  EXPECT_LT(patch.thinned.size(), 36000U);
  EXPECT_EQ(0, std::memcmp(points.data(), patch.thinned.data(), sizeof(Point))) << "the first is kept";
  std::set<Voxel> kept;
  for (const Point& p : patch.thinned) kept.insert(voxel_of(p, 0.05));
  for (const Point& p : points) {
    bool near = false;
    const Voxel v = voxel_of(p, 0.05);
    for (long k = 0; k < 27; ++k) near |= kept.count({v[0] + k / 9 - 1, v[1] + k / 3 % 3 - 1, v[2] + k % 3 - 1}) > 0;
    EXPECT_TRUE(near) << "nothing is lost";
  }
  const std::vector<Point> same(1000, point(3.0, 0.4, 0.2));
  EXPECT_EQ(1U, cells_of(same, 0, 0, CellOptions{0.2, 60.0, true}).thinned.size());
}

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

double share_divided(const PatchCells& patch, const std::function<bool(const Vector3d&)>& is_asked_for) {
  double asked = 0.0;
  double divided = 0.0;
  std::set<std::uint32_t> numbers;
  for (const DividedCell& d : patch.divided) numbers.insert(d.cell);
  for (std::uint32_t i = 0; i < patch.cells.size(); ++i) {
    if (patch.cells[i].N < 20.0 || !is_asked_for(patch.cells[i].mean)) continue;
    asked += 1.0;
    divided += numbers.count(i) > 0 ? 1.0 : 0.0;
  }
  EXPECT_GT(asked, 9.0);
  return divided / asked;
}

TEST(Cells, AreDividedWhereTwoSurfacesMeet) {
  const auto in_corner = [](const Vector3d& p) { return p.x() < 3.08 && p.z() > -1.25; };
  const auto on_wall = [](const Vector3d&) { return true; };
  EXPECT_GT(share_divided(cells_of(floor_and_wall(true, 8), 0, 0), in_corner), 0.8);
  EXPECT_LT(share_divided(cells_of(floor_and_wall(false, 9), 0, 0), on_wall), 0.3) << "most flat ones stay whole";
}

TEST(Cells, HaveAllTheirPointsInTheirParts) {
  const PatchCells patch = cells_of(floor_and_wall(true, 10), 0, 0);
  ASSERT_FALSE(patch.divided.empty());
  for (std::size_t k = 0; k < patch.divided.size(); ++k) {
    const Cell& whole = patch.cells[patch.divided[k].cell];
    const std::size_t end = k + 1 < patch.divided.size() ? patch.divided[k + 1].first_part : patch.parts.size();
    double N = 0.0;
    Matrix3d scatter = Matrix3d::Zero();
    for (std::size_t i = patch.divided[k].first_part; i < end; ++i) {
      const Cell& part = patch.parts[i];
      const Vector3d d = part.mean - whole.mean;
      N += part.N;
      scatter += part.scatter_matrix() + part.N * d * d.transpose();
    }
    EXPECT_EQ(whole.N, N);
    EXPECT_LT((scatter - whole.scatter_matrix()).norm(), 1e-12);
  }
  // Each number once, the parts in the place of their cell.
  const FinestCells finest(patch);
  std::set<std::uint32_t> numbers;
  double points = 0.0;
  finest.for_each([&](std::uint32_t number) {
    EXPECT_TRUE(numbers.insert(number).second);
    points += finest[number].N;
  });
  EXPECT_EQ(finest.count(), numbers.size());
  EXPECT_EQ(static_cast<double>(patch.points), points);
}

TEST(Cells, OfFewPointsStayWhole) {
  const PatchCells patch = cells_of({point(3.01, 0.01, 0.01), point(3.19, 0.12, 0.01), point(3.01, 0.12, 0.12),
                                     point(3.19, 0.01, 0.12), point(3.01, 0.01, 0.12)},
                                    0, 0);
  EXPECT_EQ(1U, patch.cells.size());
  EXPECT_TRUE(patch.divided.empty());
}

}  // namespace
}  // namespace rigcal
