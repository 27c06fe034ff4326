#include "core/start/surfels.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/base/parallel.h"
#include "core/start/noise_estimate.h"
#include "tests/support/make_cells.h"

namespace rigcal {
namespace {

// A wall five metres before the sensor, leaning by some ten degrees.
const Wall wall{Vector3d(5.0, 0.3, 0.2), Vector3d(0.2, 2.0, 0.0), Vector3d(-0.3, 0.0, 1.5)};

// What rings of a spinning LiDAR, evenly between two elevations, see of the walls, floor and ceiling of a room.
std::vector<Point> see_by_rings(int rings, double lowest_deg, double highest_deg, double noise_m, Random& random) {
  const Vector3d low(-6.1, -5.3, -1.3);  // in the middle of cubes
  const Vector3d high(8.3, 4.9, 2.9);
  constexpr int columns = 9000;  // five turns
  std::vector<Point> points;
  for (int ring = 0; ring < rings; ++ring) {
    const double up = to_rad(lowest_deg + (highest_deg - lowest_deg) * ring / std::max(1, rings - 1));
    for (int k = 0; k < columns; ++k) {
      const double round = 2.0 * pi * k / columns;
      const Vector3d ray(std::cos(up) * std::cos(round), std::cos(up) * std::sin(round), std::sin(up));
      double range = 1e9;
      for (int axis = 0; axis < 3; ++axis) range = std::min(range, (ray[axis] > 0.0 ? high : low)[axis] / ray[axis]);
      const Vector3d p = (range + noise_m * random.normal()) * ray;
      points.push_back({static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    }
  }
  return points;
}

double points_of(const PatchSurfels& patch) {
  double sum = 0.0;
  for (const Surfel& s : patch.surfels) sum += s.N;
  return sum;
}

TEST(Surfels, LieOnTheWallFaceTheSensorAndAreAsThickAsTheNoise) {
  Random random(1);
  const View view{800.0, pi, {0.01, 0.0, 0.0}};
  const PatchCells cells = cells_of(see({wall}, SE3{}, view, random), 2, 7);
  const PatchSurfels patch = extract_surfels(cells, SurfelOptions{});
  EXPECT_EQ(2, patch.lidar);
  EXPECT_EQ(7, patch.stop);
  ASSERT_GT(patch.surfels.size(), 40U);  // 12 m^2 in pieces of 0.25 m^2
  double variance = 0.0;
  double expected = 0.0;
  for (const Surfel& s : patch.surfels) {
    EXPECT_LT(s.normal.dot(s.mean), 0.0);
    EXPECT_NEAR(1.0, s.normal.norm(), 1e-12);
    EXPECT_GE(s.N, 20.0);
    // 1 cm over the root of N, five sigma; the smallest have a cell's width (0.2 m) across.
    EXPECT_LT(std::abs(wall.normal().dot(s.mean - wall.center)), 5.0 * 0.01 / std::sqrt(s.N));
    EXPECT_LT(s.normal.cross(wall.normal()).norm(), 5.0 * 0.01 / std::sqrt(s.N) / (0.2 / std::sqrt(12.0)));
    variance += s.N * s.variance;
    expected += s.N * view.noise.variance_along(s.mean, s.normal);
  }
  // Some 9000 points: the variance is known to sqrt(2 / 9000) = 1.5 %.
  EXPECT_NEAR(1.0, variance / expected, 4.0 * 0.015);
  // Nothing is lost but what a cube cuts off as a line or finds sliced along its face.
  EXPECT_GT(points_of(patch), 0.9 * static_cast<double>(cells.points));
}

TEST(Surfels, AreTriedInLargerCubesWhereThereAreTooFewPoints) {
  Random random(2);
  // Two points in 0.25 m^2, thirty-two in 4 m^2.
  const PatchCells cells = cells_of(see({wall}, SE3{}, View{8.0, pi, {0.01, 0.0, 0.0}}, random), 0, 0);
  const PatchSurfels patch = extract_surfels(cells, SurfelOptions{});
  ASSERT_GE(patch.surfels.size(), 2U);
  EXPECT_GT(points_of(patch), 0.5 * static_cast<double>(cells.points));
  for (const Surfel& s : patch.surfels) EXPECT_LT(s.normal.cross(wall.normal()).norm(), 0.05);
  SurfelOptions finer;
  finer.size_m = 0.1;  // at most 0.4 m: one point
  EXPECT_TRUE(extract_surfels(cells, finer).surfels.empty());
}

TEST(Surfels, AreNotMadeOfBlobsLinesAndSinglePoints) {
  Random random(3);
  std::vector<Point> points;
  for (int i = 0; i < 3000; ++i) {
    const auto x = static_cast<float>(5.0 + 0.3 * random.normal());
    const auto y = static_cast<float>(0.3 * random.normal());
    const auto z = static_cast<float>(0.3 * random.normal());
    points.push_back({x, y, z});
  }
  EXPECT_TRUE(extract_surfels(cells_of(points, 0, 0), SurfelOptions{}).surfels.empty());
  points.clear();
  for (int i = 0; i < 3000; ++i) {
    const auto along = static_cast<float>(random.uniform(-4.0, 4.0));
    const auto across = static_cast<float>(0.01 * random.normal());
    points.push_back({5.1F + 0.2F * across, along, 0.1F + across});
  }
  EXPECT_TRUE(extract_surfels(cells_of(points, 0, 0), SurfelOptions{}).surfels.empty());
  points.assign(100, {5.1F, 0.1F, 0.1F});
  EXPECT_TRUE(extract_surfels(cells_of(points, 0, 0), SurfelOptions{}).surfels.empty());
}

// Rings stand so far apart there that some pieces hold but one: planes that rays lie in, without any thickness. In some
// bins of the law there are none but these.
TEST(Surfels, OfFewRingsTellTheNoiseOfRanges) {
  Random random(6);
  const PatchSurfels patch =
      extract_surfels(cells_of(see_by_rings(16, -15.0, 15.0, 0.01, random), 0, 0), SurfelOptions{});
  const NoiseModel noise = estimate_noise({patch}, 0, {0.05, 0.0, 0.0005, 0.0});
  EXPECT_NEAR(0.01, std::sqrt(noise.range_variance(36.0, 1.0)), 0.001);
}

TEST(Surfels, OfManyPatchesAreThoseOfEachInTheirOrder) {
  Random random(4);
  const auto patches = make_patches(make_room(), turning_rig(3, Vector3d(0.2, 0.1, 0.0)), View{}, random);
  set_thread_count(2);
  const auto all = extract_surfels(patches, SurfelOptions{});
  ASSERT_EQ(patches.size(), all.size());
  for (std::size_t k = 0; k < patches.size(); ++k) {
    const PatchSurfels one = extract_surfels(patches[k], SurfelOptions{});
    EXPECT_EQ(patches[k].stop, all[k].stop);
    EXPECT_EQ(patches[k].lidar, all[k].lidar);
    ASSERT_EQ(one.surfels.size(), all[k].surfels.size());
    for (std::size_t i = 0; i < one.surfels.size(); ++i) {
      EXPECT_EQ(one.surfels[i].mean, all[k].surfels[i].mean);
      EXPECT_EQ(one.surfels[i].normal, all[k].surfels[i].normal);
    }
  }
}

}  // namespace
}  // namespace rigcal
