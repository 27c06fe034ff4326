#include "core/edges/row_lines.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/base/random.h"
#include "core/edges/outlines.h"
#include "core/edges/row_steps.h"
#include "core/edges/scan_rows.h"

namespace rigcal {
namespace {

constexpr int row_count = 90;
constexpr double lowest_rad = to_rad(-18.0);
constexpr double row_step_rad = to_rad(0.25);
constexpr double turn_step_rad = to_rad(0.2);

// A road 1.8 m below the sensor; on it, 12 m ahead, a board 3 m wide that is higher than any ray goes, and a stripe of
// paint beside it, along the road.
constexpr double road_z = -1.8;
constexpr double board_x = 12.0;
constexpr double board_y = 1.5;
constexpr double stripe_low_y = -3.3;
constexpr double stripe_high_y = -3.0;
constexpr std::uint8_t asphalt = 15;
constexpr std::uint8_t paint = 90;

enum class Ahead { nothing, board, hedge };

struct Turn {
  Ahead ahead = Ahead::board;
  bool stripe = true;
  double noise_m = 0.02;
  double tilt_rad = 0.0;  ///< What the sensor rolls by during the turn, and what is not put right.
};

void add_point(const Vector3d& p, std::uint8_t reflectivity, std::vector<Point>& points) {
  Point point;
  point.x = static_cast<float>(p.x());
  point.y = static_cast<float>(p.y());
  point.z = static_cast<float>(p.z());
  point.reflectivity = reflectivity;
  points.push_back(point);
}

std::vector<Point> turn(const Turn& how, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (int step = 0; step < 1800; ++step) {
    for (int row = 0; row < row_count; ++row) {
      // Each beam looks a little aside of the others, as in real sensors.
      const double azimuth = -pi + turn_step_rad * (step + 0.37 * (row % 3));
      const double elevation = lowest_rad + row_step_rad * row;
      const Vector3d ray(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                         std::sin(elevation));
      double range = ray.z() < 0.0 ? road_z / ray.z() : 1e3;
      const Vector3d on_road = range * ray;
      const bool on_stripe = how.stripe && on_road.y() > stripe_low_y && on_road.y() < stripe_high_y;
      std::uint8_t reflectivity = on_stripe ? paint : asphalt;
      if (how.ahead != Ahead::nothing && ray.x() > 0.0 && std::abs(ray.y() / ray.x()) * board_x < board_y &&
          board_x / ray.x() < range && (how.ahead == Ahead::board || random.uniform(0.0, 1.0) < 0.6)) {
        range = board_x / ray.x() + (how.ahead == Ahead::hedge ? random.uniform(0.0, 1.5) : 0.0);
        reflectivity = asphalt;
      }
      if (range > 80.0) continue;  // the sky
      const Eigen::AngleAxisd roll(how.tilt_rad * step / 1800.0, Vector3d::UnitX());
      add_point(roll * (ray * (range + how.noise_m * random.normal())), reflectivity, points);
    }
  }
  return points;
}

std::array<std::vector<RowStep>, cube_faces> steps_of(const Turn& how, std::uint64_t seed) {
  return find_row_steps(find_scan_rows(turn(how, seed)));
}

std::array<std::vector<StepLine>, cube_faces> lines_of(const Turn& how, std::uint64_t seed) {
  std::array<std::vector<StepLine>, cube_faces> lines;
  const auto steps = steps_of(how, seed);
  for (std::size_t face = 0; face < steps.size(); ++face) lines[face] = find_row_lines(steps[face]);
  return lines;
}

Vector3d place_of(std::size_t face, const RowStep& step) {
  return from_face({static_cast<int>(face), step.u, step.v, step.inverse_depth});
}

// Where a line has its middle, and where it goes.
struct Line3 {
  Vector3d at;
  Vector3d direction;
};

Line3 in_space(std::size_t face, const StepLine& line) {
  const auto end = [&](double s) {
    const Eigen::Vector2d uv = line.c + s * line.t;
    return from_face({static_cast<int>(face), uv.x(), uv.y(), line.inverse_depth + line.slope * s});
  };
  return {end(0.0), (end(line.high) - end(line.low)).normalized()};
}

TEST(ScanRows, AreThoseOfTheBeams) {
  const std::vector<ScanRow> rows = find_scan_rows(turn({}, 1));
  ASSERT_EQ(rows.size(), static_cast<std::size_t>(row_count));
  double last = -pi;
  for (const ScanRow& row : rows) {
    EXPECT_NEAR(row.step_rad, turn_step_rad, 1e-5);
    EXPECT_TRUE(row.closed);
    EXPECT_TRUE(std::is_sorted(row.points.begin(), row.points.end(),
                               [](const RowPoint& a, const RowPoint& b) { return a.azimuth_rad < b.azimuth_rad; }));
    const auto [low, high] =
        std::minmax_element(row.points.begin(), row.points.end(),
                            [](const RowPoint& a, const RowPoint& b) { return a.elevation_rad < b.elevation_rad; });
    EXPECT_LT(high->elevation_rad - low->elevation_rad, to_rad(0.01));
    EXPECT_GT(low->elevation_rad, last + to_rad(0.2));
    last = high->elevation_rad;
  }
}

TEST(ScanRows, AreNotFoundWhereTheSensorScansOtherwise) {
  Random random(2);
  std::vector<Point> spread;
  for (int k = 0; k < 100'000; ++k)
    add_point(10.0 * Vector3d(1.0, random.uniform(-0.5, 0.5), random.uniform(-0.3, 0.3)), asphalt, spread);
  EXPECT_TRUE(find_scan_rows(spread).empty());
  EXPECT_TRUE(find_scan_rows({}).empty());
}

TEST(ScanRows, AreNotFoundWhereATurnIsBent) {
  Turn bent;
  bent.tilt_rad = to_rad(2.0);
  EXPECT_TRUE(find_scan_rows(turn(bent, 1)).empty());
}

TEST(ScanRows, DoNotTakeWhatIsNoReturn) {
  const std::vector<Point> good = turn({}, 1);
  std::vector<Point> points = good;
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  constexpr double inf = std::numeric_limits<double>::infinity();
  for (int k = 0; k < 100; ++k) {
    add_point(Vector3d::Zero(), 0, points);
    add_point(Vector3d(nan, 1.0, 1.0), 0, points);
    add_point(Vector3d(inf, nan, 1.0), 0, points);
    add_point(Vector3d(1.0, 1.0, -inf), 0, points);
  }
  const std::vector<ScanRow> expected = find_scan_rows(good);
  const std::vector<ScanRow> rows = find_scan_rows(points);
  ASSERT_EQ(rows.size(), expected.size());
  for (std::size_t k = 0; k < rows.size(); ++k) EXPECT_EQ(rows[k].points.size(), expected[k].points.size());
}

TEST(RowSteps, AreWhereTheBoardEnds) {
  int ends = 0;
  int begins = 0;
  const auto steps = steps_of({}, 1);
  for (std::size_t face = 0; face < steps.size(); ++face) {
    for (const RowStep& step : steps[face]) {
      if (step.is_painted()) continue;
      const Vector3d p = place_of(face, step);
      ASSERT_NEAR(p.x(), board_x, 0.15) << "nothing else ends";
      const bool is_end = step.change == RowChange::ends_before_farther;
      ++(is_end ? ends : begins);
      // Within half a step of the row; the near side is left or right of it as the change says.
      EXPECT_NEAR(p.y() / p.x(), (is_end ? board_y : -board_y) / board_x, 0.51 * turn_step_rad);
      EXPECT_EQ(face, 0U);  // u is y, v is z
      EXPECT_GT((is_end ? 1.0 : -1.0) * step.towards.x(), 0.99);
      EXPECT_NEAR(step.spacing, turn_step_rad, 0.05 * turn_step_rad);
    }
  }
  // Of 51 rows on the board the lowest hardly step, since the road behind is no farther; the highest see the sky.
  EXPECT_GE(ends, 44);
  EXPECT_GE(begins, 44);
  EXPECT_LE(ends, 52);
  EXPECT_LE(begins, 52);
}

TEST(RowSteps, OfPaintAreAtTheStripe) {
  Turn road;
  road.ahead = Ahead::nothing;
  const auto steps = steps_of(road, 1);
  int brighter = 0;
  int darker = 0;
  for (std::size_t face = 0; face < steps.size(); ++face) {
    for (const RowStep& step : steps[face]) {
      ASSERT_TRUE(step.is_painted());
      const Vector3d p = place_of(face, step);
      const double along = std::abs(p.x()) / p.head<2>().norm();
      if (along < 0.3) continue;  // beside the vehicle rows run along the stripe
      const double azimuth_to_y = p.head<2>().norm() * turn_step_rad / along;
      // Ahead, growing azimuth is growing y; behind it is not.
      const bool low_side = (step.change == RowChange::gets_brighter) == (p.x() > 0.0);
      EXPECT_NEAR(p.y(), low_side ? stripe_low_y : stripe_high_y, 1.6 * azimuth_to_y + 0.02);
      ++(step.change == RowChange::gets_brighter ? brighter : darker);
    }
  }
  EXPECT_GT(brighter, 20);
  EXPECT_GT(darker, 20);
}

TEST(RowSteps, OfAnEvenRoadAreNone) {
  Turn road;
  road.ahead = Ahead::nothing;
  road.stripe = false;
  for (const auto& face : steps_of(road, 1)) EXPECT_TRUE(face.empty());
}

void turn_about(std::vector<Point>& points) {
  for (Point& p : points) {
    p.x = -p.x;
    p.y = -p.y;
  }
}

TEST(RowSteps, AreTheSameWhereATurnCloses) {
  std::vector<Point> points = turn({}, 1);
  const auto ahead = find_row_steps(find_scan_rows(points));
  turn_about(points);
  const auto behind = find_row_steps(find_scan_rows(points));
  // The board is on face 0 at first, and on its opposite then.
  ASSERT_FALSE(ahead[0].empty());
  EXPECT_EQ(behind[1].size(), ahead[0].size());
}

TEST(RowSteps, AreNotWhereARecordedSectorEnds) {
  Turn road;
  road.ahead = Ahead::nothing;
  road.stripe = false;
  std::vector<Point> points = turn(road, 1);
  std::erase_if(points, [](const Point& p) { return std::abs(p.y) > 2.0F * p.x; });
  for (int k = 0; k < 2; ++k) {
    const std::vector<ScanRow> rows = find_scan_rows(points);
    ASSERT_FALSE(rows.empty());
    for (const ScanRow& row : rows) EXPECT_FALSE(row.closed);
    for (const auto& face : find_row_steps(rows)) EXPECT_TRUE(face.empty());
    turn_about(points);
  }
}

TEST(RowLines, AreTheBoardsSidesAndTheStripes) {
  for (const std::uint64_t seed : {1, 2, 3}) {
    std::set<std::string> found;
    const auto lines = lines_of({}, seed);
    for (std::size_t face = 0; face < lines.size(); ++face) {
      for (const StepLine& line : lines[face]) {
        const auto [at, direction] = in_space(face, line);
        if (!line.painted) {
          EXPECT_NEAR(std::abs(at.y()) / at.x(), board_y / board_x, 0.3 * turn_step_rad) << at.transpose();
          EXPECT_GT(std::abs(direction.z()), 0.99);
          // Its right side, seen along t, is where the farther surface is.
          EXPECT_GT(line.n().x() * at.y(), 0.0);
          found.insert(at.y() > 0.0 ? "left side" : "right side");
        } else {
          EXPECT_GT(std::abs(direction.x()), 0.99) << at.transpose();
          EXPECT_NEAR(at.z(), road_z, 0.05);
          EXPECT_LT(std::min(std::abs(at.y() - stripe_low_y), std::abs(at.y() - stripe_high_y)), 0.04);
          found.insert(std::string(at.x() > 0.0 ? "ahead, " : "behind, ") +
                       (at.y() < 0.5 * (stripe_low_y + stripe_high_y) ? "far" : "near"));
        }
        EXPECT_GT(line.shift, 0.0);
        EXPECT_LT(line.shift, 0.3 * line.spacing);
      }
    }
    EXPECT_EQ(found, (std::set<std::string>{"left side", "right side", "ahead, far", "ahead, near", "behind, far",
                                            "behind, near"}))
        << seed;
  }
}

TEST(RowLines, DoNotHoldStepsOfOtherOnesTwice) {
  for (const auto& face : lines_of({}, 1)) {
    std::set<std::uint32_t> seen;
    for (const StepLine& line : face) {
      for (const std::uint32_t i : line.steps) EXPECT_TRUE(seen.insert(i).second);
    }
  }
}

TEST(RowLines, OfAHedgeAreFew) {
  Turn hedge;
  hedge.ahead = Ahead::hedge;
  hedge.stripe = false;
  const auto steps = steps_of(hedge, 1);
  ASSERT_GT(steps[0].size(), 150U);
  std::size_t in_lines = 0;
  for (const StepLine& line : find_row_lines(steps[0])) in_lines += line.steps.size();
  EXPECT_LT(in_lines, steps[0].size() / 10);
}

TEST(Outlines, OfASpinningLidarComeFromItsRows) {
  PatchCells patch;
  patch.thinned = turn({}, 1);
  RigState state;
  state.T_G_base = {SE3{}};
  state.T_base_sensor = {SE3{}};
  const std::vector<LidarEdge> edges = find_outlines({patch}, state, {}, 0, {{0.003, 0.003}});
  std::size_t sides = 0;
  std::size_t stripes = 0;
  for (const LidarEdge& edge : edges) {
    const Vector3d& p = edge.p_G;
    if (std::abs(p.x() - board_x) < 0.1 && p.z() > road_z + 0.1) {
      ++sides;
      // The beam is cut in two there: returns come from the board while less than half of it is past its end.
      EXPECT_LT(std::abs(p.y()), board_y);
    } else {
      ++stripes;
      EXPECT_LT(std::min(std::abs(p.y() - stripe_low_y), std::abs(p.y() - stripe_high_y)), 0.06) << p.transpose();
    }
    EXPECT_GT(edge.shift_m, 0.0);
  }
  EXPECT_GT(sides, 10U);
  EXPECT_GT(stripes, 40U);
}

}  // namespace
}  // namespace rigcal
