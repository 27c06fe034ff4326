#include "core/voxel/plane_map.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "tests/core/voxel/naive_plane_map.h"
#include "tests/support/make_cells.h"
#include "tests/support/make_planes.h"

namespace rigcal {
namespace {

const std::vector<NoiseModel> two_lidars(2);

// Two stops half a metre apart, one LiDAR.
RigState two_stops() {
  RigState state;
  state.T_G_base = {SE3{}, {exp_so3(Vector3d(0.02, -0.01, 0.3)), Vector3d(0.1, 0.5, 0.05)}};
  state.T_base_sensor = {SE3{}};
  return state;
}

// Points given in the world, as the exact patch of a stop.
PatchCells patch_of(const std::vector<Vector3d>& points_G, const RigState& state, int stop) {
  std::vector<Point> points;
  const SE3 T = state.T_G_sensor(stop, 0).inverse();
  for (const Vector3d& p_G : points_G) {
    const Vector3d p = T * p_G;
    Point point;
    point.x = static_cast<float>(p.x());
    point.y = static_cast<float>(p.y());
    point.z = static_cast<float>(p.z());
    points.push_back(point);
  }
  return cells_of(points, 0, stop);
}

// A box of points: uniform within +- half, with normal noise on top.
std::vector<Vector3d> box_of_points(const Vector3d& center, const Vector3d& half, double noise, int count,
                                    Random& random) {
  std::vector<Vector3d> points;
  for (int i = 0; i < count; ++i) {
    Vector3d p = center;
    for (int k = 0; k < 3; ++k) {
      const double place = random.uniform(-1.0, 1.0);
      p[k] += half[k] * place + noise * random.normal();
    }
    points.push_back(p);
  }
  return points;
}

PlaneMap map_of(const std::vector<PatchCells>& patches, const RigState& state, const PlaneMapOptions& options = {},
                const SE3& T_grid_G = {}) {
  return build_plane_map(patches, state, two_lidars, T_grid_G, options);
}

double points_in(const PlaneMap& map) {
  double sum = 0.0;
  for (const PlaneFeature& f : map.features)
    for (const PlaneObservation& o : f.observations) sum += o.N;
  return sum;
}

TEST(PlaneMap, HasTheLeavesOfANaiveMapOnRandomScenes) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    const RigState state = turning_rig(3, Vector3d(0.2, 0.1, 0.0));
    std::vector<Wall> walls;
    for (int k = 0; k < 8; ++k) {
      const SE3 T = random_pose(random, 1.0, 3.0);
      walls.push_back({T.t, T.R.col(0) * random.uniform(0.2, 2.0), T.R.col(1) * random.uniform(0.2, 2.0)});
    }
    const auto patches = make_patches(walls, state, View{}, random);
    const SE3 T_grid_G = random_pose(random, 1.0, 1.0);
    const PlaneMap map = build_plane_map(patches, state, two_lidars, T_grid_G, PlaneMapOptions{});
    const NaivePlaneMap naive(patches, state, two_lidars, T_grid_G, PlaneMapOptions{});
    ASSERT_EQ(naive.features().size(), map.features.size()) << "seed " << seed;
    ASSERT_GT(map.features.size(), 10U);
    for (const PlaneFeature& f : map.features) {
      const PlaneFeature* twin = naive.nearest(f.center_G);
      EXPECT_EQ(twin->size_m, f.size_m);
      // The same sums in another order.
      EXPECT_LT((twin->center_G - f.center_G).norm(), 1e-9);
      EXPECT_GT(std::abs(twin->normal_G.dot(f.normal_G)), 1.0 - 1e-9);
      ASSERT_EQ(twin->observations.size(), f.observations.size());
      for (std::size_t a = 0; a < f.observations.size(); ++a) {
        EXPECT_EQ(twin->observations[a].stop, f.observations[a].stop);
        EXPECT_EQ(twin->observations[a].lidar, f.observations[a].lidar);
        EXPECT_EQ(twin->observations[a].N, f.observations[a].N);
      }
    }
    EXPECT_EQ(naive.leaves_dropped(), map.counts.leaves_dropped);
  }
}

TEST(PlaneMap, FindsThePlaneThatTwoPatchesSaw) {
  Random random(11);
  const RigState state = two_stops();
  // Inside the root voxel [4, 6) x [-2, 0) x [0, 2), leaning.
  const Wall wall{Vector3d(5.0, -1.0, 1.0), Vector3d(0.1, 0.6, 0.0), Vector3d(-0.2, 0.0, 0.6)};
  const auto patches = make_patches({wall}, state, View{2000.0, pi, {}}, random);
  const PlaneMap map = map_of(patches, state);
  ASSERT_EQ(1U, map.features.size());
  const PlaneFeature& f = map.features[0];
  EXPECT_EQ(2.0, f.size_m);
  ASSERT_EQ(2U, f.observations.size());
  // 2 cm over the root of some 5900 points, and a plane 0.7 m wide (1 sigma 0.35 m): five sigma.
  const double sigma = 0.02 / std::sqrt(points_in(map));
  EXPECT_NEAR(0.0, wall.normal().dot(f.center_G - wall.center), 5.0 * sigma);
  EXPECT_LT(f.normal_G.cross(wall.normal()).norm(), 5.0 * sigma / 0.35);
  EXPECT_EQ(map.counts.cells, patches[0].pieces.size() + patches[1].pieces.size());
  // Left out may be what the sensor's grid slices off the wall's face, where it falls into a column of its own.
  EXPECT_GT(static_cast<double>(map.counts.cells_used), 0.93 * static_cast<double>(map.counts.cells));
  EXPECT_EQ(map.counts.cells, map.counts.cells_used + map.counts.cells_gated);
  EXPECT_EQ(0U, map.counts.leaves_dropped);
}

TEST(PlaneMap, ObservationsAreTheSumsOfTheirPoints) {
  Random random(12);
  const RigState state = two_stops();
  const Wall wall{Vector3d(5.0, -1.0, 1.0), Vector3d(0.1, 0.6, 0.0), Vector3d(-0.2, 0.0, 0.6)};
  View view{3000.0, pi, {}};
  view.noise.range_m = 0.01;  // half of what the map is told, so that its gates keep all
  const auto points = see({wall}, state.T_G_sensor(1, 0), view, random);
  const std::vector<PatchCells> patches{cells_of(see({wall}, state.T_G_sensor(0, 0), view, random), 0, 0),
                                        cells_of(points, 0, 1)};
  const PlaneMap map = map_of(patches, state);
  ASSERT_EQ(1U, map.features.size());
  ASSERT_EQ(0U, map.counts.cells_gated);
  const PlaneObservation& o = map.features[0].observations.at(1);
  EXPECT_EQ(1, o.stop);
  EXPECT_EQ(static_cast<double>(points.size()), o.N);
  // Of the points, but for what the noise of their ranges has done at the borders of pieces.
  Vector3d mean = Vector3d::Zero();
  for (const Point& p : points) mean += Vector3d(p.x, p.y, p.z) / o.N;
  const auto moved = [](const Cell& piece) {
    return Vector3d(piece.noise_shift_per_m * 0.02 * 0.02 * piece.mean.normalized());
  };
  for (const Cell& piece : patches[1].pieces) mean -= piece.N / o.N * moved(piece);
  Matrix3d scatter = Matrix3d::Zero();
  Matrix3d share = Matrix3d::Zero();
  for (const Cell& piece : patches[1].pieces) {
    const Vector3d off = piece.mean - moved(piece) - mean;
    scatter += piece.scatter_matrix() + piece.N * off * off.transpose();
    const NoiseModel noise;
    const Matrix3d along = 0.02 * 0.02 * piece.mean.normalized() * piece.mean.normalized().transpose();
    const Vector3d u = state.T_G_sensor(1, 0).R.transpose() * map.features[0].normal_G;
    const double put_back = std::pow(0.02 * piece.noise_shift_per_m, 2);
    share += piece.N * (noise.point_covariance(piece.mean, u) - (1.0 - piece.noise_share) * along +
                        (1.0 - piece.noise_share - put_back) * u.dot(along * u) * u * u.transpose());
  }
  EXPECT_LT((o.mean - mean).norm(), 1e-12);
  EXPECT_LT((o.scatter + share - scatter).norm(), 1e-9 * scatter.norm());
  // What a plane is not (1 mm) is added to the mean's noise and caps the weight.
  const double variance = NoiseModel{}.variance_along(mean, state.T_G_sensor(1, 0).R.transpose() * wall.normal());
  EXPECT_NEAR(variance / o.N + 1e-6, o.offset_variance, 0.01 * o.offset_variance);
  EXPECT_NEAR(1.0 / (variance + o.N * 1e-6), o.weight, 0.01 * o.weight);
}

// A border between depths cuts a wall that is met straight by its noise: the gate must not leave out one side.
TEST(PlaneMap, HoldsAWallOneSigmaBehindABorderWhereItStands) {
  RigState state;
  state.T_G_base = {SE3{}, {Matrix3d::Identity(), Vector3d(0.0, 0.3, 0.1)}};
  state.T_base_sensor = {SE3{}};
  const double distance = 9.02;
  const int count = 15'000;  // So that what noise brings before the border is a few points each cell.
  Random random(14);
  double sum = 0.0;
  double kept = 0.0;
  for (int run = 0; run < 20; ++run) {
    std::vector<PatchCells> patches;
    for (int stop = 0; stop < 2; ++stop) {
      std::vector<Vector3d> points;
      const Vector3d& sensor = state.T_G_base[static_cast<std::size_t>(stop)].t;
      for (int i = 0; i < count; ++i) {
        const Vector3d ray = Vector3d(1.0, random.uniform(-0.3, 0.3), random.uniform(-0.3, 0.3)).normalized();
        points.emplace_back(sensor + (distance / ray.x() + 0.02 * random.normal()) * ray);
      }
      patches.push_back(patch_of(points, state, stop));
    }
    const PlaneMap map = map_of(patches, state);
    kept += points_in(map);
    for (const PlaneFeature& f : map.features)
      for (const PlaneObservation& o : f.observations) sum += o.N * (o.mean.x() - distance);
  }
  EXPECT_GT(kept, 0.95 * 40 * count);
  EXPECT_NEAR(sum / kept, 0.0, 4.0 * 0.02 / std::sqrt(kept));
}

TEST(PlaneMap, TakesTheNoiseOutOfTheScatterThatWouldTurnAnObliquePlane) {
  Random random(13);
  RigState state;
  state.T_G_base = {SE3{}, {Matrix3d::Identity(), Vector3d(0.0, 0.02, 0.01)}};
  state.T_base_sensor = {SE3{}};
  // Met at 60 degrees in the horizontal plane, in the middle of the root voxel [4, 6) x [-1, 1)^2 of a shifted grid.
  const Vector3d normal(0.5, std::sqrt(0.75), 0.0);
  const Vector3d along(std::sqrt(0.75), -0.5, 0.0);
  const Wall wall{Vector3d(5.0, 0.0, 0.0), 0.6 * along, 0.6 * Vector3d::UnitZ()};
  const auto patches = make_patches({wall}, state, View{70000.0, pi, {}}, random);
  const PlaneMap map = map_of(patches, state, {}, {Matrix3d::Identity(), Vector3d(0.0, 1.0, 1.0)});
  ASSERT_EQ(1U, map.features.size());
  ASSERT_EQ(2U, map.features[0].observations.size());
  for (std::size_t k = 0; k < 2; ++k) {
    const PlaneObservation& o = map.features[0].observations[k];
    ASSERT_GT(o.N, 0.98 * static_cast<double>(patches[k].points));
    const double cross = normal.dot(o.scatter * along);
    // The noise's torque is N sigma^2 sin i cos i; the cross term's own error is that of N products of a distance
    // off the plane (sigma cos i) and a place in it (0.6 m / sqrt 3).
    const double torque = o.N * 0.02 * 0.02 * 0.5 * std::sqrt(0.75);
    const double error = std::sqrt(o.N) * 0.02 * 0.5 * 0.6 / std::sqrt(3.0);
    ASSERT_GT(torque, 10.0 * error);
    EXPECT_NEAR(0.0, cross, 4.0 * error);
    // Across the plane nothing is left either: sigma^2 cos^2 i of each point, known to sqrt(2 / N) and to the floor.
    EXPECT_NEAR(0.0, normal.dot(o.scatter * normal), 0.02 * o.N * 0.02 * 0.02 * 0.25);
  }
}

// A wall and the floor that it stands on, seen from two stops.
TEST(PlaneMap, OfCubesHasTheirPointsToo) {
  Random random(8);
  const RigState state = two_stops();
  std::vector<Vector3d> points = box_of_points({3.1, 0.0, 0.2}, {0.0, 1.5, 1.5}, 0.005, 20000, random);
  const auto floor = box_of_points({2.2, 0.0, -1.3}, {0.9, 1.5, 0.0}, 0.005, 20000, random);
  points.insert(points.end(), floor.begin(), floor.end());
  const std::vector<PatchCells> patches{patch_of(points, state, 0), patch_of(points, state, 1)};
  PlaneMapOptions whole;
  whole.by_cubes = true;
  const PlaneMap map = map_of(patches, state, whole);
  EXPECT_EQ(patches[0].cells.size() + patches[1].cells.size(), map.counts.cells);
  EXPECT_LT(map.counts.cells, map_of(patches, state).counts.cells);
  EXPECT_GT(points_in(map), 0.6 * 2.0 * static_cast<double>(points.size()));
}

TEST(PlaneMap, RejectsWhatOnlyOnePatchSaw) {
  Random random(14);
  const RigState state = two_stops();
  const Wall wall{Vector3d(5.0, -1.0, 1.0), Vector3d(0.1, 0.6, 0.0), Vector3d(-0.2, 0.0, 0.6)};
  auto patches = make_patches({wall}, state, View{2000.0, pi, {}}, random);
  const PlaneMap left_out = build_plane_map(patches, state, two_lidars, {}, {}, {1, 0});
  EXPECT_TRUE(left_out.features.empty());
  EXPECT_EQ(patches[0].pieces.size(), left_out.counts.cells);
  EXPECT_EQ(0U, left_out.counts.cells_used);
  EXPECT_EQ(1U, left_out.counts.leaves_dropped);
  patches[1] = cells_of({}, 0, 1);
  EXPECT_TRUE(map_of(patches, state).features.empty());
}

TEST(PlaneMap, KeepsWhatOnlyOnePatchSawWhereOneIsEnough) {
  Random random(5);
  const auto wall = box_of_points({0.5, 0.5, 0.5}, {0.4, 0.4, 0.0}, 0.001, 500, random);
  PlaneMapOptions options;
  options.min_patches = 1;
  const PlaneMap map = map_of({patch_of(wall, two_stops(), 0)}, two_stops(), options);
  ASSERT_FALSE(map.features.empty());
  for (const PlaneFeature& f : map.features) {
    EXPECT_EQ(f.observations.size(), 1U);
    EXPECT_NEAR(std::abs(f.normal_G.z()), 1.0, 1e-3);
    EXPECT_NEAR(f.center_G.z(), 0.5, 1e-3);
  }
}

TEST(PlaneMap, RejectsALine) {
  Random random(15);
  RigState state = two_stops();
  state.T_G_base[1].R.setIdentity();
  // A lath 2 m long and 3 cm wide, flat to 2 mm: but for its narrowness a plane.
  std::vector<PatchCells> patches;
  for (int j = 0; j < 2; ++j) {
    const auto points = box_of_points(Vector3d(5.1, -1.0, 1.1), Vector3d(0.0, 0.9, 0.015), 0.002, 2000, random);
    patches.push_back(patch_of(points, state, j));
  }
  // In smaller voxels its pieces are no lines any more.
  PlaneMapOptions lines_too;
  lines_too.min_size_m = 0.25;
  EXPECT_TRUE(map_of(patches, state, lines_too).features.empty());
  lines_too.max_elongation = 1e9;
  EXPECT_FALSE(map_of(patches, state, lines_too).features.empty());
}

TEST(PlaneMap, RejectsAStripWhoseWidthIsNoise) {
  Random random(17);
  RigState state;
  state.T_G_base = {SE3{}, {Matrix3d::Identity(), Vector3d(0.0, 0.02, 0.0)}};
  state.T_base_sensor = {SE3{}};
  // An edge at the height of the sensor, straight across its view: range noise makes a level strip of it.
  const auto map_of_width = [&](double half_m) {
    std::vector<PatchCells> patches;
    for (int j = 0; j < 2; ++j) {
      std::vector<Vector3d> points =
          box_of_points(Vector3d(5.06, 0.06, 0.03), Vector3d(half_m, 0.05, 0.0), 0.001, 2000, random);
      for (Vector3d& p : points) p.x() += two_lidars[0].range_m * random.normal();
      patches.push_back(patch_of(points, state, j));
    }
    return map_of(patches, state);
  };
  EXPECT_TRUE(map_of_width(0.0).features.empty());
  EXPECT_FALSE(map_of_width(0.06).features.empty());
}

TEST(PlaneMap, RejectsABlob) {
  Random random(16);
  const RigState state = two_stops();
  std::vector<PatchCells> patches;
  for (int j = 0; j < 2; ++j) {
    patches.push_back(patch_of(box_of_points(Vector3d(5.0, -1.0, 1.0), Vector3d::Zero(), 0.3, 5000, random), state, j));
  }
  const PlaneMap map = map_of(patches, state);
  EXPECT_TRUE(map.features.empty());
  EXPECT_EQ(0U, map.counts.cells_used);
  EXPECT_GT(map.counts.leaves_dropped, 10U);
}

struct Walker {
  const char* name;
  double before_wall_m;  // middle of the body
  double half_height_m;  // four times the half width
  bool gated;            // near enough for the wall's voxel to pass as a plane with the person in it
};

class PersonBeforeAWall : public ::testing::TestWithParam<Walker> {};

TEST_P(PersonBeforeAWall, IsLeftOutWhileTheWallStays) {
  Random random(17);
  const RigState state = two_stops();
  constexpr double wall_x = 5.3;  // not in a face of the grid
  const Wall wall{Vector3d(wall_x, -1.0, 1.0), Vector3d(0.0, 0.95, 0.0), Vector3d(0.0, 0.0, 0.95)};
  std::vector<PatchCells> patches;
  std::size_t cells_of_person = 0;
  for (int j = 0; j < 2; ++j) {
    auto points = see({wall}, state.T_G_sensor(j, 0), View{2000.0, pi, {}}, random);
    if (j == 1) {
      // As dense as the wall behind.
      const double h = GetParam().half_height_m;
      const auto body = box_of_points(Vector3d(wall_x - GetParam().before_wall_m, -1.0, 1.0),
                                      Vector3d(0.04, 0.25 * h, h), 0.01, static_cast<int>(2000.0 * h * h), random);
      const SE3 T = state.T_G_sensor(1, 0).inverse();
      std::vector<Point> seen;
      for (const Vector3d& p_G : body) seen.push_back(measured(T * p_G, NoiseModel{}, random));
      cells_of_person = cells_of(seen, 0, 1).pieces.size();
      points.insert(points.end(), seen.begin(), seen.end());
    }
    patches.push_back(cells_of(points, 0, j));
  }
  const PlaneMap map = map_of(patches, state);
  ASSERT_FALSE(map.features.empty());
  for (const PlaneFeature& f : map.features) {
    // The smallest pieces of wall have 30 points of 2 cm on 0.25 m: good to 2 cm / sqrt(30) / 0.07 m = 3 degrees.
    EXPECT_GT(std::abs(f.normal_G.x()), std::cos(to_rad(6.0)));
    for (const PlaneObservation& o : f.observations) {
      const SE3 T = state.T_G_sensor(o.stop, o.lidar);
      EXPECT_NEAR(wall_x, (T * o.mean).x(), 0.005 + 4.0 * 0.02 / std::sqrt(o.N));
    }
  }
  if (GetParam().gated) {
    EXPECT_GT(map.counts.cells_gated, cells_of_person / 2);
  }
  const std::size_t cells_of_wall = map.counts.cells - cells_of_person;
  EXPECT_GT(static_cast<double>(map.counts.cells_used), 0.85 * static_cast<double>(cells_of_wall));
}

INSTANTIATE_TEST_SUITE_P(Walkers, PersonBeforeAWall,
                         ::testing::Values(Walker{"leaning_child", 0.25, 0.4, true},
                                           Walker{"passing", 0.8, 0.8, false}),
                         [](const auto& param) { return param.param.name; });

// A tenth of a metre wide, before a sensor that looks along x: `off_m` behind the wall at 5.1 m, so many times as thick
// as noise of 2 cm makes it.
Cell piece_of_wall(double y, double z, double N, double off_m, double thick) {
  constexpr double noise_m = 0.02;
  Cell piece;
  piece.N = N;
  piece.mean = {5.1 + off_m, y, z};
  piece.scatter << (N - 1.0) * thick * noise_m * noise_m, 0.0, 0.0, N * 0.01 / 12.0, 0.0, N * 0.01 / 12.0;
  return piece;
}

// Of a few points, or thick: what a column of a hundred points hides.
TEST(PlaneMap, LeavesOutSinglePiecesOfOtherSurfaces) {
  const RigState state{{SE3{}, SE3{}}, {SE3{}}};
  std::vector<PatchCells> patches(2);
  for (int stop = 0; stop < 2; ++stop) {
    PatchCells& patch = patches[static_cast<std::size_t>(stop)];
    patch.stop = stop;
    for (int y = 0; y < 10; ++y) {
      for (int z = 0; z < 10; ++z)
        patch.pieces.push_back(piece_of_wall(0.05 + 0.1 * y, 0.05 + 0.1 * z, 20.0, 0.0, 1.0));
    }
  }
  const PlaneMap alone = map_of(patches, state);
  ASSERT_EQ(1U, alone.features.size());
  ASSERT_EQ(2U, alone.features[0].observations.size());
  EXPECT_EQ(2000.0, alone.features[0].observations[0].N);
  EXPECT_EQ(0U, alone.counts.cells_gated);

  // Within what noise does to four points (1 cm) and to twenty.
  patches[0].pieces.push_back(piece_of_wall(0.33, 0.33, 4.0, 0.035, 1.0));
  patches[0].pieces.push_back(piece_of_wall(0.63, 0.33, 20.0, 0.0, 1.5));
  const PlaneMap with_noise = map_of(patches, state);
  ASSERT_EQ(1U, with_noise.features.size());
  EXPECT_EQ(2024.0, with_noise.features[0].observations[0].N);

  patches[1].pieces.push_back(piece_of_wall(0.33, 0.63, 4.0, 0.048, 1.0));
  patches[1].pieces.push_back(piece_of_wall(0.63, 0.63, 20.0, 0.0, 3.0));
  const PlaneMap with_others = map_of(patches, state);
  ASSERT_EQ(1U, with_others.features.size());
  EXPECT_EQ(2024.0, with_others.features[0].observations[0].N);
  EXPECT_EQ(2000.0, with_others.features[0].observations[1].N);
  EXPECT_NEAR(5.1, with_others.features[0].observations[1].mean.x(), 1e-9);
  EXPECT_EQ(2U, with_others.counts.cells_gated);
}

TEST(PlaneMap, UsesAsMuchWhereverTheGridStands) {
  Random random(18);
  const RigState state = turning_rig(4, Vector3d(0.2, 0.1, 0.0));
  const auto patches = make_patches(make_room(), state, View{}, random);
  const auto used = static_cast<double>(map_of(patches, state).counts.cells_used);
  EXPECT_GT(used, 0.85 * static_cast<double>(map_of(patches, state).counts.cells));
  for (int k = 0; k < 5; ++k) {
    const SE3 T_grid_G = random_pose(random, 1.0, 1.0);
    EXPECT_NEAR(used, static_cast<double>(map_of(patches, state, {}, T_grid_G).counts.cells_used), 0.05 * used);
  }
}

TEST(PlaneMap, IsTheSameToTheBitForOneAndTwoThreads) {
  Random random(19);
  const RigState state = turning_rig(4, Vector3d(0.2, 0.1, 0.0));
  const auto patches = make_patches(make_room(), state, View{}, random);
  set_thread_count(1);
  const PlaneMap one = map_of(patches, state);
  set_thread_count(2);
  const PlaneMap two = map_of(patches, state);
  ASSERT_EQ(one.features.size(), two.features.size());
  for (std::size_t l = 0; l < one.features.size(); ++l) {
    EXPECT_EQ(one.features[l].center_G, two.features[l].center_G);
    EXPECT_EQ(one.features[l].normal_G, two.features[l].normal_G);
    ASSERT_EQ(one.features[l].observations.size(), two.features[l].observations.size());
    for (std::size_t a = 0; a < one.features[l].observations.size(); ++a) {
      EXPECT_EQ(one.features[l].observations[a].mean, two.features[l].observations[a].mean);
      EXPECT_EQ(one.features[l].observations[a].scatter, two.features[l].observations[a].scatter);
      EXPECT_EQ(one.features[l].observations[a].weight, two.features[l].observations[a].weight);
    }
  }
  EXPECT_EQ(one.counts.cells_used, two.counts.cells_used);
  EXPECT_EQ(one.counts.cells_gated, two.counts.cells_gated);
  EXPECT_EQ(one.counts.leaves_dropped, two.counts.leaves_dropped);
}

}  // namespace
}  // namespace rigcal
