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
constexpr std::size_t patch_count = 30;
constexpr std::size_t patch_points = 40'000;  // All together more than are looked up at once.

std::vector<PatchCells> random_patches() {
  Random random(3);
  std::vector<PatchCells> patches;
  for (int k = 0; k < static_cast<int>(patch_count); ++k) {
    PatchCells patch{k % 2, k / 2 % 3, 0, {}, {}, {}, 0};
    for (std::size_t i = 0; i < patch_points; ++i) {
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
std::vector<MapPoint> expected(const std::vector<PatchCells>& patches, const RigState& state, std::size_t every = 1) {
  std::vector<MapPoint> map;
  std::set<std::array<long, 3>> taken;
  for (const PatchCells& patch : patches) {
    for (std::size_t i = 0; i < patch.thinned.size(); i += every) {
      const Point& p = patch.thinned[i];
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
  EXPECT_LT(wanted.size(), patch_count * patch_points - 1000);
  const int before = thread_count();
  for (const int threads : {1, 2, 3}) {
    set_thread_count(threads);
    EXPECT_TRUE(same(fuse_map(patches, state, std::vector<char>(patch_count, 1), {4, 7}, size_m), wanted)) << threads;
  }
  set_thread_count(before);
}

TEST(FuseMap, LeavesOutPatchesThatTookNoPart) {
  const std::vector<PatchCells> patches = random_patches();
  std::vector<char> use(patch_count, 0);
  for (std::size_t k = 0; k < patch_count; k += 2) use[k] = 1;
  for (const MapPoint& p : fuse_map(patches, random_state(), use, {4, 7}, size_m)) {
    ASSERT_EQ(p.sensor, 4);
  }
  EXPECT_TRUE(fuse_map(patches, random_state(), std::vector<char>(patch_count, 0), {4, 7}, size_m).empty());
}

TEST(FuseMap, LooksAtFewerPointsWhereThatIsEnough) {
  const std::vector<PatchCells> patches = random_patches();
  const RigState state = random_state();
  EXPECT_TRUE(same(fuse_map(patches, state, std::vector<char>(patch_count, 1), {4, 7}, size_m, 3),
                   expected(patches, state, 3)));
}

TEST(FuseMap, KeepsEveryPointWhereNoSizeIsGiven) {
  EXPECT_EQ(fuse_map(random_patches(), random_state(), std::vector<char>(patch_count, 1), {4, 7}, 0.0).size(),
            patch_count * patch_points);
}

}  // namespace
}  // namespace rigcal
