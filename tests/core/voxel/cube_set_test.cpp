#include "core/voxel/cube_set.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>
#include <vector>

#include "core/base/random.h"

namespace rigcal {
namespace {

// Against a plain set of cubes, over calls of several chunks.
TEST(CubeSet, TellsTheFirstPointOfEachCube) {
  Random random(5);
  CubeSet cubes(0.1);
  std::set<std::array<int, 3>> known;
  for (int call = 0; call < 3; ++call) {
    std::vector<Eigen::Vector3f> points;
    for (int i = 0; i < 40'000; ++i) {
      points.push_back(Eigen::Vector3d(random.normal(), random.normal(), random.normal()).cast<float>());
    }
    std::vector<char> is_first(points.size(), 2);
    cubes.add(points, is_first);
    for (std::size_t i = 0; i < points.size(); ++i) {
      const auto part = [](float x) { return static_cast<int>(std::floor(x * 10.0)); };
      const bool first = known.insert({part(points[i].x()), part(points[i].y()), part(points[i].z())}).second;
      ASSERT_EQ(is_first[i], first ? 1 : 0);
    }
  }
  EXPECT_GT(known.size(), 20'000U);
}

// Far out, too, and on both sides of a block's border.
TEST(CubeSet, TellsNeighboursApartWhereverTheyAre) {
  CubeSet cubes(0.02);
  std::vector<Eigen::Vector3f> points;
  for (const float from : {-100.0F, -0.2F, 0.0F, 99.0F}) {
    for (int i = 0; i < 40; ++i) points.emplace_back(from + 0.02F * static_cast<float>(i) + 0.01F, from, -from);
  }
  std::vector<char> is_first(points.size(), 2);
  cubes.add(points, is_first);
  // Those from -0.2 and from 0 m differ in y and z.
  EXPECT_EQ(std::count(is_first.begin(), is_first.end(), 1), std::ssize(points));
  cubes.add(points, is_first);
  EXPECT_EQ(std::count(is_first.begin(), is_first.end(), 0), std::ssize(points));
}

}  // namespace
}  // namespace rigcal
