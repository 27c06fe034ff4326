#include "core/edges/outlines.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "core/base/parallel.h"
#include "core/base/random.h"
#include "core/edges/step_lines.h"

namespace rigcal {
namespace {

Point point_at(const Vector3d& p) {
  Point point;
  point.x = static_cast<float>(p.x());
  point.y = static_cast<float>(p.y());
  point.z = static_cast<float>(p.z());
  return point;
}

// A board 2 m wide and 1.5 m high, 8 m away along x, before a wall at 12 m, and a floor 1 m below the sensor.
constexpr double board_x = 8.0;
constexpr double board_y = 1.0;
constexpr double board_low = -0.5;
constexpr double board_high = 1.0;

struct Scan {
  int rays = 200'000;  ///< Spread over 50 x 40 degrees: 1.8 mrad apart.
  double noise_m = 0.02;
  bool board = true;
  bool floor = true;
  bool leaves = false;  ///< In place of the board a hedge whose rays end anywhere within 0.5 m.
};

std::vector<Point> scan(const Scan& how, std::uint64_t seed) {
  Random random(seed);
  std::vector<Point> points;
  for (int k = 0; k < how.rays; ++k) {
    const double u = random.uniform(-0.47, 0.47);
    const double v = random.uniform(-0.36, 0.36);
    double depth = how.floor && v < -1.0 / 12.0 ? std::min(12.0, 1.0 / -v) : 12.0;
    const bool hit = std::abs(board_x * u) < board_y && board_x * v > board_low && board_x * v < board_high;
    if (how.leaves && hit && random.uniform(0.0, 1.0) < 0.7)
      depth = std::min(depth, board_x + random.uniform(-0.25, 0.25));
    if (how.board && !how.leaves && hit) depth = std::min(depth, board_x);
    const Vector3d ray(1.0, u, v);
    points.push_back(point_at(ray * (depth + how.noise_m * random.normal() / ray.norm())));
  }
  return points;
}

PatchCells patch_of(std::vector<Point> points, int lidar = 0, int stop = 0) {
  PatchCells patch;
  patch.lidar = lidar;
  patch.stop = stop;
  patch.thinned = std::move(points);
  return patch;
}

RigState at_origin() {
  RigState state;
  state.T_G_base = {SE3{}};
  state.T_base_sensor = {SE3{}};
  return state;
}

std::vector<BeamWidth> without_beam() { return {{0.0, 0.0}}; }

// Distance of a point, seen from the sensor, to the nearest side of the board, as an angle; the floor hides what lies
// below -1 m only.
double off_board_rad(const Vector3d& p) {
  const double y = p.y() / p.x();
  const double z = p.z() / p.x();
  return std::min({std::abs(std::abs(y) - board_y / board_x), std::abs(z - board_low / board_x),
                   std::abs(z - board_high / board_x)});
}

TEST(CubeFaces, TakeEveryDirectionAndGiveItBack) {
  Random random(3);
  std::set<int> faces;
  for (int k = 0; k < 200; ++k) {
    const Vector3d p(random.normal(), random.normal(), random.normal());
    const FacePlace at = to_face(p);
    faces.insert(at.face);
    EXPECT_LE(std::abs(at.u), 1.0);
    EXPECT_LE(std::abs(at.v), 1.0);
    EXPECT_GT(at.inverse_depth, 0.0);
    EXPECT_LT((from_face(at) - p).norm(), 1e-12 * p.norm());
  }
  EXPECT_EQ(faces.size(), 6U);
}

TEST(DepthSteps, AreWhereTheBoardEndsAndHardlyElsewhere) {
  const auto steps = find_depth_steps(scan({}, 1));
  std::size_t on = 0;
  std::size_t elsewhere = 0;
  for (std::size_t face = 0; face < steps.size(); ++face) {
    for (const DepthStep& step : steps[face]) {
      EXPECT_GT(step.rise_m, 0.1);
      const Vector3d place = from_face({static_cast<int>(face), step.u, step.v, step.inverse_depth});
      const bool at_board = off_board_rad(place) < 0.006 && std::abs(place.x() - board_x) < 0.1;
      ++(at_board ? on : elsewhere);
    }
  }
  EXPECT_GT(on, 300U);
  EXPECT_LT(elsewhere, 1000U) << "of 200000 rays; noise on the floor, which no line holds together";
}

TEST(DepthSteps, OfAWallAreNone) {
  Scan wall;
  wall.board = false;
  wall.floor = false;
  for (const auto& face : find_depth_steps(scan(wall, 2))) EXPECT_TRUE(face.empty());
}

TEST(Outlines, OfAFloorAndAWallAreNone) {
  Scan empty;
  empty.board = false;
  EXPECT_TRUE(find_outlines({patch_of(scan(empty, 2))}, at_origin(), {}, 0, without_beam()).empty());
}

TEST(DepthSteps, OfNothingAreNone) {
  for (const auto& face : find_depth_steps({})) EXPECT_TRUE(face.empty());
  const std::vector<Point> zeros(100, point_at(Vector3d::Zero()));
  for (const auto& face : find_depth_steps(zeros)) EXPECT_TRUE(face.empty());
}

TEST(Outlines, OfABoardLieOnItsSidesAsSureAsTheySay) {
  double squares = 0.0;
  std::size_t count = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4, 5}) {
    const std::vector<LidarEdge> edges = find_outlines({patch_of(scan({}, seed))}, at_origin(), {}, 7, without_beam());
    std::set<int> lines;
    int upright = 0;
    int level = 0;
    for (const LidarEdge& edge : edges) {
      lines.insert(edge.line);
      (std::abs(edge.direction_G.z()) > 0.9 ? upright : level) += 1;
      EXPECT_NEAR(edge.direction_G.norm(), 1.0, 1e-9);
      EXPECT_NEAR(edge.p_G.x(), board_x, 0.1);
      EXPECT_DOUBLE_EQ(edge.shift_m, 0.0);
      const Vector3d across = edge.p_G.cross(edge.direction_G).normalized();
      const double sigma_rad = std::sqrt(across.dot(edge.covariance_G * across)) / edge.p_G.norm();
      const double off = off_board_rad(edge.p_G);
      EXPECT_LT(off, 5.0 * sigma_rad + 0.0005);
      EXPECT_LT(sigma_rad, 0.0008) << "a third of the rays' distance";
      squares += off * off / (sigma_rad * sigma_rad);
      ++count;
    }
    EXPECT_EQ(*lines.begin(), 7);
    EXPECT_GE(lines.size(), 4U);
    EXPECT_GT(upright, 20);
    EXPECT_GT(level, 20);
  }
  EXPECT_LT(squares / static_cast<double>(count), 3.0);
}

TEST(Outlines, TurnWithTheRig) {
  RigState state = at_origin();
  state.T_G_base[0] = {exp_so3(Vector3d(0.2, -0.1, 1.1)), Vector3d(3.0, -2.0, 0.5)};
  const std::vector<LidarEdge> edges = find_outlines({patch_of(scan({}, 1))}, state, {}, 0, without_beam());
  ASSERT_GT(edges.size(), 50U);
  for (const LidarEdge& edge : edges) EXPECT_LT(off_board_rad(state.T_G_base[0].inverse() * edge.p_G), 0.003);
}

TEST(Outlines, AHedgeHasNone) {
  Scan hedge;
  hedge.leaves = true;
  EXPECT_LT(find_outlines({patch_of(scan(hedge, 4))}, at_origin(), {}, 0, without_beam()).size(), 40U);
}

TEST(Outlines, AWideBeamMovesThemInwardsAndMakesThemLessSure) {
  const std::vector<BeamWidth> wide{{0.005, 0.0005}};
  const auto narrow_edges = find_outlines({patch_of(scan({}, 1))}, at_origin(), {}, 0, without_beam());
  const auto wide_edges = find_outlines({patch_of(scan({}, 1))}, at_origin(), {}, 0, wide);
  const auto top = [](const std::vector<LidarEdge>& edges) {
    double sum = 0.0;
    int count = 0;
    double shift = 0.0;
    for (const LidarEdge& edge : edges) {
      if (std::abs(edge.p_G.z() / edge.p_G.x() - board_high / board_x) > 0.006 || std::abs(edge.direction_G.z()) > 0.5)
        continue;
      sum += edge.p_G.z() / edge.p_G.x();
      shift += edge.shift_m;
      ++count;
    }
    return std::pair(sum / count, shift / count);
  };
  EXPECT_NEAR(top(narrow_edges).first - top(wide_edges).first, 0.0025, 0.0006);
  EXPECT_NEAR(top(wide_edges).second, 0.7 * 0.0025 * board_x, 0.003);
  // Upright ones hardly: the beam is narrow there.
  for (const LidarEdge& edge : wide_edges) {
    if (std::abs(edge.direction_G.z()) < 0.9) continue;
    EXPECT_LT(edge.shift_m, 0.002);
  }
}

TEST(Outlines, OfTwoPatchesHaveTheSameNumbersAndNoSampleTwice) {
  const std::vector<PatchCells> once{patch_of(scan({}, 1))};
  const std::vector<PatchCells> twice{patch_of(scan({}, 1)), patch_of(scan({}, 2))};
  const auto numbers = [](const std::vector<LidarEdge>& edges) {
    std::set<int> out;
    for (const LidarEdge& edge : edges) out.insert(edge.line);
    return out.size();
  };
  const auto one = find_outlines(once, at_origin(), {}, 0, without_beam());
  const auto two = find_outlines(twice, at_origin(), {}, 0, without_beam());
  EXPECT_LE(numbers(two), numbers(one) + 1);
  EXPECT_LT(two.size(), 2 * one.size() - one.size() / 3);
  const auto second_left_out = find_outlines(twice, at_origin(), {1, 0}, 0, without_beam());
  EXPECT_EQ(second_left_out.size(), one.size());
}

TEST(Outlines, AreTheSameFromWhatWasFoundBefore) {
  const std::vector<PatchCells> patches{patch_of(scan({}, 1)), patch_of(scan({}, 2))};
  std::vector<PatchOutlines> known;
  for (const PatchCells& patch : patches) known.push_back(find_patch_outlines(patch, without_beam()));
  const auto found = find_outlines(patches, at_origin(), {}, 5, without_beam());
  const auto again = find_outlines(patches, at_origin(), {}, 5, without_beam(), &known);
  ASSERT_FALSE(found.empty());
  ASSERT_EQ(found.size(), again.size());
  for (std::size_t k = 0; k < found.size(); ++k) {
    EXPECT_EQ(found[k].p_G, again[k].p_G);
    EXPECT_EQ(found[k].line, again[k].line);
    EXPECT_EQ(found[k].covariance_G, again[k].covariance_G);
  }
  known[1] = {};
  EXPECT_LT(find_outlines(patches, at_origin(), {}, 5, without_beam(), &known).size(), found.size());
}

TEST(Outlines, AreTheSameOnAnyNumberOfThreads) {
  const std::vector<PatchCells> patches{patch_of(scan({}, 1)), patch_of(scan({}, 2)), patch_of(scan({}, 3))};
  const auto samples = [&](int threads) {
    set_thread_count(threads);
    std::vector<Vector3d> out;
    for (const LidarEdge& edge : find_outlines(patches, at_origin(), {}, 0, {})) out.push_back(edge.p_G);
    return out;
  };
  const int before = thread_count();
  const auto one = samples(1);
  const auto four = samples(4);
  set_thread_count(before);
  EXPECT_TRUE(one == four);
}

}  // namespace
}  // namespace rigcal
