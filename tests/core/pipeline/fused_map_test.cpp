#include "core/pipeline/fused_map.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

#include "core/base/parallel.h"
#include "core/base/random.h"

namespace rigcal {
namespace {

constexpr double size_m = 0.02;

std::vector<PatchCells> random_patches() {
  Random random(3);
  std::vector<PatchCells> patches;
  for (int k = 0; k < 6; ++k) {
    PatchCells patch{k % 2, k / 2, 0, {}, {}};
    for (int i = 0; i < 40'000; ++i) {
      const auto part = [&] { return static_cast<float>(random.uniform(-0.5, 0.5)); };
      patch.thinned.push_back({part(), part(), part(), static_cast<std::uint8_t>(i), 0, 0});
    }
    patches.push_back(std::move(patch));
  }
  return patches;
}

RigState random_state() {
  Random random(4);
  RigState state;
  for (int j = 0; j < 3; ++j) {
    Vector6d xi;
    for (int i = 0; i < 6; ++i) xi[i] = 0.2 * random.normal();
    state.T_G_base.push_back(SE3::exp(xi));
  }
  state.T_base_sensor = {SE3{}, {exp_so3({0.0, 0.1, 0.3}), {0.1, 0.0, 0.05}}};
  return state;
}

// The first point of each cube, in the plainest way.
std::vector<MapPoint> expected(const std::vector<PatchCells>& patches, const RigState& state) {
  std::vector<MapPoint> map;
  std::set<std::array<long, 3>> taken;
  for (const PatchCells& patch : patches) {
    for (const Point& p : patch.thinned) {
      const Eigen::Vector3f g = (state.T_G_sensor(patch.stop, patch.lidar) * Vector3d(p.x, p.y, p.z)).cast<float>();
      const auto cube = [](float x) { return static_cast<long>(std::floor(x * (1.0 / size_m))); };
      if (!taken.insert({cube(g.x()), cube(g.y()), cube(g.z())}).second) continue;
      map.push_back({g.x(), g.y(), g.z(), p.reflectivity, static_cast<std::uint8_t>(patch.lidar == 0 ? 4 : 7)});
    }
  }
  return map;
}

bool same(const std::vector<MapPoint>& a, const std::vector<MapPoint>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](const MapPoint& p, const MapPoint& q) {
    return p.x == q.x && p.y == q.y && p.z == q.z && p.reflectivity == q.reflectivity && p.sensor == q.sensor;
  });
}

TEST(FuseMap, KeepsTheFirstPointOfEachCubeWithAnyNumberOfThreads) {
  const std::vector<PatchCells> patches = random_patches();
  const RigState state = random_state();
  const std::vector<MapPoint> wanted = expected(patches, state);
  EXPECT_GT(wanted.size(), 100'000U);
  EXPECT_LT(wanted.size(), 239'000U);
  const int before = thread_count();
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    EXPECT_TRUE(same(fuse_map(patches, state, std::vector<char>(6, 1), {4, 7}, size_m), wanted)) << threads;
  }
  set_thread_count(before);
}

TEST(FuseMap, LeavesOutPatchesThatTookNoPart) {
  const std::vector<PatchCells> patches = random_patches();
  for (const MapPoint& p : fuse_map(patches, random_state(), {1, 0, 1, 0, 1, 0}, {4, 7}, size_m)) {
    ASSERT_EQ(p.sensor, 4);
  }
  EXPECT_TRUE(fuse_map(patches, random_state(), std::vector<char>(6, 0), {4, 7}, size_m).empty());
}

TEST(FuseMap, KeepsEveryPointWhereNoSizeIsGiven) {
  EXPECT_EQ(fuse_map(random_patches(), random_state(), std::vector<char>(6, 1), {4, 7}, 0.0).size(), 240'000U);
}

}  // namespace
}  // namespace rigcal
