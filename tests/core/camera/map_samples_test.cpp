#include "core/camera/map_samples.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr double size_m = 0.05;

// A floor at z = 2 cm and a wall at x = 2.02 m, in the world, both in the middle of cubes; the leaves of a tree above.
Vector3d random_surface_point(Random& random) {
  const double u = random.uniform(-1.0, 1.0);
  const double v = random.uniform();
  switch (random.below(3)) {
    case 0:
      return {1.0 + u, 2.0 * v - 1.0, 0.02};
    case 1:
      return {2.02, u, 2.0 * v};
    default:
      return Vector3d(0.0, 0.0, 1.5) + 0.3 * Vector3d(u, 2.0 * v - 1.0, random.uniform(-1.0, 1.0));
  }
}

bool in_corner(const MapSample& s) { return s.p_G.x() > 1.99F && s.p_G.z() < 0.1F; }
bool on_wall(const MapSample& s) { return s.p_G.x() > 1.99F && s.p_G.z() > 0.1F; }

PlaneFeature leaf_at(const Vector3d& center, const Vector3d& normal) {
  PlaneFeature leaf;
  leaf.center_G = center;
  leaf.normal_G = normal;
  leaf.size_m = 2.0;
  return leaf;
}

class MapSamplesTest : public testing::Test {
 protected:
  void SetUp() override {
    Random random(7);
    state_.T_G_base = {SE3{}, {exp_so3({0.02, -0.1, 1.0}), {0.3, -0.2, 0.1}}};
    state_.T_base_sensor = {{Matrix3d::Identity(), {0.0, 0.0, 1.0}}, {exp_so3({0.3, 0.1, 2.0}), {0.1, 0.1, 1.2}}};
    for (int stop = 0; stop < 2; ++stop) {
      for (int lidar = 0; lidar < 2; ++lidar) {
        PatchCells patch;
        patch.stop = stop;
        patch.lidar = lidar;
        const SE3 T_sensor_G = state_.T_G_sensor(stop, lidar).inverse();
        // The first LiDAR has more points; the second says twice as much of the same surface.
        for (int i = 0; i < (lidar == 0 ? 60'000 : 20'000); ++i) {
          const Vector3d g = random_surface_point(random);
          const Eigen::Vector3f p = (T_sensor_G * g).cast<float>();
          const int reflectivity = g.x() > 2.01 ? 100 : 40;
          patch.thinned.push_back({p.x(), p.y(), p.z(), static_cast<std::uint8_t>(reflectivity * (1 + lidar)), 0, 0});
        }
        patches_.push_back(patch);
      }
    }
    // Whichever way round the map has the normals.
    leaves_ = {leaf_at({1.0, 0.0, 0.02}, -Vector3d::UnitZ()), leaf_at({2.02, 0.0, 1.0}, Vector3d::UnitX())};
  }

  RigState state_;
  std::vector<PatchCells> patches_;
  std::vector<PlaneFeature> leaves_;
};

TEST_F(MapSamplesTest, OneForEachCubeWithNormalTowardsWhoSawIt) {
  const std::vector<MapSample> samples = sample_map(patches_, state_, {}, leaves_);
  std::map<std::array<int, 3>, int> cubes;
  int floor = 0;
  int wall = 0;
  int leafage = 0;
  for (const MapSample& s : samples) {
    // Means of points stay inside their cubes.
    ++cubes[{static_cast<int>(std::floor(s.p_G.x() / size_m)), static_cast<int>(std::floor(s.p_G.y() / size_m)),
             static_cast<int>(std::floor(s.p_G.z() / size_m))}];
    if (s.p_G.z() < 0.05F && s.p_G.x() < 1.9F) {
      ++floor;
      EXPECT_LT((s.normal_G - Eigen::Vector3f::UnitZ()).norm(), 1e-5F);
    } else if (on_wall(s) && s.p_G.z() < 1.9F && std::abs(s.p_G.y()) < 0.9F) {
      ++wall;
      EXPECT_LT((s.normal_G + Eigen::Vector3f::UnitX()).norm(), 1e-5F);
    } else if (s.p_G.x() < 0.9F && s.p_G.z() > 1.1F) {
      ++leafage;
      EXPECT_EQ(s.normal_G.norm(), 0.0F);
    }
  }
  EXPECT_EQ(cubes.size(), samples.size());
  EXPECT_GT(floor, 1500);
  EXPECT_GT(wall, 1000);
  EXPECT_GT(leafage, 500);
}

TEST_F(MapSamplesTest, ReflectivityIsTheMedianOfTheLidarWithMostPoints) {
  int of_other = 0;
  const std::vector<MapSample> samples = sample_map(patches_, state_, {}, leaves_);
  for (const MapSample& s : samples) {
    if (in_corner(s)) continue;
    EXPECT_EQ(s.reflectivity, (on_wall(s) ? 100 : 40) * (1 + s.lidar));
    of_other += s.lidar;
  }
  EXPECT_LT(of_other, static_cast<int>(samples.size() / 10));
  // Of the second LiDAR alone.
  for (const MapSample& s : sample_map(patches_, state_, {0, 1, 0, 1}, leaves_)) {
    ASSERT_EQ(s.lidar, 1);
    if (in_corner(s)) continue;
    ASSERT_EQ(s.reflectivity, on_wall(s) ? 200 : 80);
  }
}

TEST_F(MapSamplesTest, MergedPlanesAreNoLeaves) {
  for (PlaneFeature& leaf : leaves_) leaf.merged = true;
  for (const MapSample& s : sample_map(patches_, state_, {}, leaves_)) ASSERT_EQ(s.normal_G.norm(), 0.0F);
}

TEST_F(MapSamplesTest, OfTooManyPointsEverySecondTakesPart) {
  const std::vector<MapSample> all = sample_map(patches_, state_, {}, leaves_);
  const std::vector<MapSample> half = sample_map(patches_, state_, {}, leaves_, size_m, 80'000);
  std::vector<PatchCells> thinner = patches_;
  for (PatchCells& patch : thinner) {
    std::vector<Point> kept;
    for (std::size_t i = 0; i < patch.thinned.size(); i += 2) kept.push_back(patch.thinned[i]);
    patch.thinned = kept;
  }
  const std::vector<MapSample> expected = sample_map(thinner, state_, {}, leaves_);
  const auto same = [](const MapSample& a, const MapSample& b) { return a.p_G == b.p_G; };
  EXPECT_FALSE(std::equal(half.begin(), half.end(), all.begin(), all.end(), same)) << "all points took part";
  ASSERT_EQ(half.size(), expected.size());
  for (std::size_t k = 0; k < half.size(); ++k) {
    ASSERT_EQ(half[k].p_G, expected[k].p_G);
    ASSERT_EQ(half[k].reflectivity, expected[k].reflectivity);
  }
}

TEST_F(MapSamplesTest, TheSameWithAnyNumberOfThreads) {
  const int before = thread_count();
  std::vector<std::vector<MapSample>> all;
  for (const int threads : {1, 3}) {
    set_thread_count(threads);
    all.push_back(sample_map(patches_, state_, {}, leaves_));
  }
  set_thread_count(before);
  EXPECT_TRUE(std::equal(
      all[0].begin(), all[0].end(), all[1].begin(), all[1].end(), [](const MapSample& a, const MapSample& b) {
        return a.p_G == b.p_G && a.normal_G == b.normal_G && a.reflectivity == b.reflectivity && a.lidar == b.lidar;
      }));
}

TEST_F(MapSamplesTest, EmptyFromNothing) {
  EXPECT_TRUE(sample_map({}, state_, {}, leaves_).empty());
  EXPECT_TRUE(sample_map(patches_, state_, std::vector<char>(4, 0), leaves_).empty());
  EXPECT_FALSE(sample_map(patches_, state_, {}, {}).empty());
}

}  // namespace
}  // namespace rigcal
