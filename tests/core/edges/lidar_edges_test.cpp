#include "core/edges/lidar_edges.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/parallel.h"
#include "core/edges/edge_candidates.h"
#include "core/geometry/symmetric_eigen.h"
#include "core/voxel/plane_map.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

// A room seen by a rig on a turntable, with the map of its planes.
struct SeenRoom {
  std::vector<Wall> walls = make_room();
  RigState state = turning_rig(8, {0.1, -0.05, 0.0});
  std::vector<NoiseModel> noise{{0.01, 0.0, 0.0003}, {0.015, 0.0, 0.0003}};
  std::vector<PatchCells> patches;
  PlaneMap map;

  explicit SeenRoom(std::uint64_t seed) {
    Random random(seed);
    CellOptions options;
    options.keep_thinned = true;
    for (int j = 0; j < 8; ++j) {
      for (int i = 0; i < 2; ++i) {
        const View view{400.0, to_rad(50.0), noise[static_cast<std::size_t>(i)]};
        patches.push_back(cells_of(see(walls, state.T_G_sensor(j, i), view, random), i, j, options));
      }
    }
    map = build_plane_map(patches, state, noise, SE3{}, {});
  }

  [[nodiscard]] std::vector<LidarEdge> edges() const {
    return find_lidar_edges(map.features, patches, state, noise, {});
  }
};

// Distance of p to a rectangle's plane, or infinity beside the rectangle (samples may run 5 cm beyond its corner).
double distance(const Wall& wall, const Vector3d& p) {
  const Vector3d d = p - wall.center;
  const double a = wall.u.dot(d) / wall.u.squaredNorm();
  const double b = wall.v.dot(d) / wall.v.squaredNorm();
  if (std::abs(a) > 1.0 + 0.05 / wall.u.norm() || std::abs(b) > 1.0 + 0.05 / wall.v.norm()) return 1e9;
  return std::abs(wall.normal().dot(d));
}

// The distances to the two nearest walls.
std::pair<double, double> two_nearest(const std::vector<Wall>& walls, const Vector3d& p) {
  std::vector<double> all;
  for (const Wall& wall : walls) all.push_back(distance(wall, p));
  std::partial_sort(all.begin(), all.begin() + 2, all.end());
  return {all[0], all[1]};
}

TEST(LidarEdges, LieWhereTwoWallsMeetAsSureAsTheySay) {
  double squares = 0.0;
  double worst = 0.0;
  std::size_t count = 0;
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SeenRoom room(seed);
    const std::vector<LidarEdge> edges = room.edges();
    // Twelve edges of the room make 68 m, of which boards and their surroundings hide some.
    EXPECT_GT(edges.size(), 1200U);
    for (const LidarEdge& edge : edges) {
      const auto [near, far] = two_nearest(room.walls, edge.p_G);
      const double sigma2 = symmetric_eigen(edge.covariance_G).values[2];
      ASSERT_LT(far, 5.0 * std::sqrt(sigma2)) << edge.p_G.transpose();
      worst = std::max(worst, far);
      squares += (near * near + far * far) / sigma2;
      ++count;
    }
  }
  // Two distances of a sigma each; the covariance keeps a millimetre for what real walls are not.
  const double mean = squares / static_cast<double>(count);
  EXPECT_LT(mean, 2.5);
  EXPECT_GT(mean, 0.1);
  EXPECT_LT(worst, 0.02);
  RecordProperty("mean_square_over_variance", std::to_string(mean));
  std::printf("%zu samples, mean square over variance %.3f, worst %.4f m\n", count, mean, worst);
}

// What is met at a slant is cut at its borders, and noise along the rays must not turn it there: corners of a room
// would come nearer, all of them.
TEST(LidarEdges, OfARoomAreNeitherTooNearNorTooFar) {
  Vector3d inside = Vector3d::Zero();  // of the edges of walls that stand along x, y and z
  Vector3d count = Vector3d::Zero();
  for (const std::uint64_t seed : {1, 2, 3}) {
    const SeenRoom room(seed);
    for (const LidarEdge& edge : room.edges()) {
      const Vector3d p = (edge.p_G - Vector3d(0.0, 0.0, 0.2)).cwiseAbs();  // from the room's middle
      const Vector3d beyond = p - Vector3d(4.0, 3.0, 1.5);
      Vector3d near = Vector3d::Zero();
      for (Eigen::Index axis = 0; axis < 3; ++axis) near[axis] = std::abs(beyond[axis]) < 0.02 ? 1.0 : 0.0;
      if (near.sum() != 2.0) continue;  // an edge of a board, or a corner of three walls
      inside -= near.cwiseProduct(beyond);
      count += near;
    }
  }
  ASSERT_GT(count.minCoeff(), 1000.0);
  const Vector3d mean_mm = 1e3 * inside.cwiseQuotient(count);
  std::printf("nearer by %.2f, %.2f and %.2f mm\n", mean_mm.x(), mean_mm.y(), mean_mm.z());
  EXPECT_LT(mean_mm.cwiseAbs().maxCoeff(), 0.3);
}

TEST(LidarEdges, RunAlongTheirWallsAndShareALineWithTheirNeighbours) {
  const SeenRoom room(4);
  const std::vector<LidarEdge> edges = room.edges();
  int on_floor_edge = 0;
  std::vector<int> lines;
  for (const LidarEdge& edge : edges) {
    EXPECT_NEAR(edge.direction_G.dot(edge.normal_a_G), 0.0, 1e-9);
    EXPECT_NEAR(edge.direction_G.dot(edge.normal_b_G), 0.0, 1e-9);
    EXPECT_NEAR((edge.covariance_G * edge.direction_G).norm(), 0.0, 1e-12);
    // The edge of the floor with the wall at x = 4.
    if (std::abs(edge.p_G.x() - 4.0) > 0.02 || std::abs(edge.p_G.z() + 1.3) > 0.02) continue;
    if (std::abs(edge.direction_G.y()) < 0.5) continue;  // one of the two that end there
    ++on_floor_edge;
    lines.push_back(edge.line);
    EXPECT_GT(std::abs(edge.direction_G.y()), 0.999);
  }
  EXPECT_GT(on_floor_edge, 150);  // of 240 for its 6 m
  EXPECT_EQ(std::count(lines.begin(), lines.end(), lines.front()), static_cast<long>(lines.size()));
}

TEST(LidarEdges, AreNotInventedWhereAFaceEndsBeforeTheOther) {
  // A wall that floats 25 cm above the floor: their planes meet, their surfaces do not.
  SeenRoom room(5);
  room.walls = {{Vector3d(3, 0, -1), 3.0 * Vector3d::UnitX(), 3.0 * Vector3d::UnitY()},
                {Vector3d(4, 0, 0.25), 2.0 * Vector3d::UnitY(), Vector3d::UnitZ()}};
  Random random(5);
  CellOptions options;
  options.keep_thinned = true;
  for (PatchCells& patch : room.patches) {
    const SE3 T = room.state.T_G_sensor(patch.stop, patch.lidar);
    patch = cells_of(see(room.walls, T, {400.0, pi, room.noise[0]}, random), patch.lidar, patch.stop, options);
  }
  room.map = build_plane_map(room.patches, room.state, room.noise, SE3{}, {});
  ASSERT_GT(room.map.features.size(), 10U);
  EXPECT_TRUE(room.edges().empty());
}

TEST(LidarEdges, AreTheSameWithOneThreadAndTwo) {
  const SeenRoom room(6);
  const int before = thread_count();
  set_thread_count(1);
  const std::vector<LidarEdge> one = room.edges();
  set_thread_count(2);
  const std::vector<LidarEdge> two = room.edges();
  set_thread_count(before);
  ASSERT_EQ(one.size(), two.size());
  for (std::size_t i = 0; i < one.size(); ++i) {
    ASSERT_EQ(one[i].p_G, two[i].p_G);
    ASSERT_EQ(one[i].line, two[i].line);
  }
}

TEST(LidarEdges, ComeFromNoStrips) {
  SeenRoom room(1);
  for (PlaneFeature& leaf : room.map.features) leaf.size_m = 0.125;
  EXPECT_TRUE(edge_candidates(room.map.features).empty());
  for (PlaneFeature& leaf : room.map.features) leaf.size_m = 0.25;
  EXPECT_FALSE(edge_candidates(room.map.features).empty());
}

TEST(LidarEdges, NothingComesFromNothing) { EXPECT_TRUE(find_lidar_edges({}, {}, {}, {}, {}).empty()); }

TEST(Intersect, IsOnBothPlanesNextToThePoint) {
  Random random(7);
  for (int k = 0; k < 50; ++k) {
    const auto direction = [&] { return Vector3d(random.normal(), random.normal(), random.normal()).normalized(); };
    const WorldPlane a{direction(), random.normal()};
    const WorldPlane b{direction(), random.normal()};
    if (std::abs(a.n.dot(b.n)) > 0.95) continue;
    const Vector3d near(random.normal(), random.normal(), random.normal());
    const Line3 line = intersect(a, b, near);
    EXPECT_NEAR(a.distance(line.p), 0.0, 1e-9);
    EXPECT_NEAR(b.distance(line.p), 0.0, 1e-9);
    EXPECT_NEAR(line.direction.dot(line.p - near), 0.0, 1e-9);
  }
}

}  // namespace
}  // namespace rigcal
